// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/tables/table.h"

// The table of floor plans; FORMAT.md says what each column means. It is plain, and only in maps
// that have some.
namespace waystone {

inline constexpr TableDescriptor kFloorPlansTable{
    "floor_plans", 1,
    std::array{IntegerColumn("id"), TextColumn("name"), IntegerColumn("width"),
               IntegerColumn("height"), OrNull(RealColumn("low")), OrNull(RealColumn("high")),
               IntegerColumn("anchor_count"), BlobColumn("anchors"), BlobColumn("image")}};

inline constexpr const char* kFloorPlansSql =
    "CREATE TABLE floor_plans (\n"
    "  id INTEGER PRIMARY KEY,\n"
    "  name TEXT NOT NULL,\n"
    "  width INTEGER NOT NULL,\n"
    "  height INTEGER NOT NULL,\n"
    "  low REAL,\n"
    "  high REAL,\n"
    "  anchor_count INTEGER NOT NULL,\n"
    "  anchors_crc32c INTEGER NOT NULL,\n"
    "  anchors BLOB NOT NULL,\n"
    "  image_crc32c INTEGER NOT NULL,\n"
    "  image BLOB NOT NULL\n"
    ") STRICT";

}  // namespace waystone
