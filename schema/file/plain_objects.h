// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/file/map_database.h"

namespace waystone {

// Whether somebody else's object may stand in a map: a table of columns with types and at most
// PRIMARY KEY, NOT NULL and UNIQUE, or an index over columns, with names of letters, digits and
// underscores. Its definition holds no expression, so nothing in it can be evaluated. FORMAT.md has
// the rule. Pure.
bool IsPlainObject(const SchemaObject& object);

}  // namespace waystone
