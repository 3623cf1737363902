// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/tables/table.h"

// The tables of named places; FORMAT.md says what each column means. They are plain, and only in
// maps that have something to put there.
namespace waystone {

inline constexpr TableDescriptor kPlaceRangesTable{
    "place_ranges", 1,
    std::array{IntegerColumn("id"), TextColumn("name"), IntegerColumn("kind"),
               IntegerColumn("first_id"), IntegerColumn("last_id")}};

inline constexpr const char* kPlaceRangesSql =
    "CREATE TABLE place_ranges (\n"
    "  id INTEGER PRIMARY KEY,\n"
    "  name TEXT NOT NULL,\n"
    "  kind INTEGER NOT NULL,\n"
    "  first_id INTEGER NOT NULL,\n"
    "  last_id INTEGER NOT NULL\n"
    ") STRICT";

inline constexpr TableDescriptor kPlacePolygonsTable{
    "place_polygons", 1,
    std::array{IntegerColumn("id"), TextColumn("name"), IntegerColumn("corner_count"),
               BlobColumn("corners")}};

inline constexpr const char* kPlacePolygonsSql =
    "CREATE TABLE place_polygons (\n"
    "  id INTEGER PRIMARY KEY,\n"
    "  name TEXT NOT NULL,\n"
    "  corner_count INTEGER NOT NULL,\n"
    "  corners_crc32c INTEGER NOT NULL,\n"
    "  corners BLOB NOT NULL\n"
    ") STRICT";

}  // namespace waystone
