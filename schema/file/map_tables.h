// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/tables/table.h"

// The tables that all layers share, and the list of all tables; FORMAT.md says what each column
// means.
namespace waystone {

inline constexpr TableDescriptor kMapTable{
    "map", 1,
    std::array{IntegerColumn("id"), TextColumn("name"), TextColumn("program"),
               IntegerColumn("feature_type"), TextColumn("options")}};

inline constexpr TableDescriptor kSequencesTable{
    "sequences", 1,
    std::array{IntegerColumn("id"), TextColumn("name"), TextColumn("kind"), IntegerColumn("frames"),
               IntegerColumn("skipped"), OrNull(IntegerColumn("camera_model")),
               OrNull(IntegerColumn("camera_width")), OrNull(IntegerColumn("camera_height")),
               OrNull(BlobColumn("camera_params"))}};

inline constexpr TableDescriptor kContentsTable{
    "contents", 1,
    std::array{TextColumn("table_name"), IntegerColumn("row_count"), IntegerColumn("crc32c")}};

// Every table of a map, in the order of FORMAT.md. Thread-safe.
const std::vector<TableView>& AllTables();

}  // namespace waystone
