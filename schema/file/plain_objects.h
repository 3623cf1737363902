// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/file/map_database.h"

namespace waystone {

// Whether a foreign object may be in a map: a table of columns with types and at most PRIMARY KEY,
// NOT NULL and UNIQUE, or an index over columns, with names of letters, digits and underscores. Its
// definition has no expression, so nothing in it can be evaluated. FORMAT.md has the rule. Pure;
// thread-safe.
bool IsPlainObject(const SchemaObject& object);

}  // namespace waystone
