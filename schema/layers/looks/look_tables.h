// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/tables/table.h"

// The tables of what later walks looked for; FORMAT.md says what each column means. They are plain,
// and only in maps that have something to put there.
namespace waystone {

inline constexpr TableDescriptor kPlaneLooksTable{
    "plane_looks", 1,
    std::array{IntegerColumn("id"), IntegerColumn("plane"), IntegerColumn("sequence"),
               IntegerColumn("feature_count"), BlobColumn("looks")}};

inline constexpr const char* kPlaneLooksSql =
    "CREATE TABLE plane_looks (\n"
    "  id INTEGER PRIMARY KEY,\n"
    "  plane INTEGER NOT NULL,\n"
    "  sequence INTEGER NOT NULL,\n"
    "  feature_count INTEGER NOT NULL,\n"
    "  looks_crc32c INTEGER NOT NULL,\n"
    "  looks BLOB NOT NULL\n"
    ") STRICT";

inline constexpr TableDescriptor kLandmarkLooksTable{
    "landmark_looks", 1,
    std::array{IntegerColumn("id"), IntegerColumn("keyframe"), IntegerColumn("sequence"),
               IntegerColumn("landmark_count"), BlobColumn("looks")}};

inline constexpr const char* kLandmarkLooksSql =
    "CREATE TABLE landmark_looks (\n"
    "  id INTEGER PRIMARY KEY,\n"
    "  keyframe INTEGER NOT NULL,\n"
    "  sequence INTEGER NOT NULL,\n"
    "  landmark_count INTEGER NOT NULL,\n"
    "  looks_crc32c INTEGER NOT NULL,\n"
    "  looks BLOB NOT NULL\n"
    ") STRICT";

}  // namespace waystone
