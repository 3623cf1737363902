// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/tables/table.h"

// The table of links between keyframes; FORMAT.md says what each column means. It is plain, and
// only in maps that have something to put there.
namespace waystone {

inline constexpr TableDescriptor kKeyframeLinksTable{
    "keyframe_links", 1, std::array{IntegerColumn("id"), IntegerColumn("a"), IntegerColumn("b")}};

inline constexpr const char* kKeyframeLinksSql =
    "CREATE TABLE keyframe_links (\n"
    "  id INTEGER PRIMARY KEY,\n"
    "  a INTEGER NOT NULL,\n"
    "  b INTEGER NOT NULL\n"
    ") STRICT";

}  // namespace waystone
