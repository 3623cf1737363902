// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

#include <vector>

#include "schema/file/map_store.h"
#include "schema/map_data.h"

namespace waystone {

// What could be read of a map, and what could not.
struct Reading {
  MapData map;  // of the rows without a problem
  std::vector<MapProblem> problems;
};

// Reads the tables of a map of this program's version, checking every value, blob and count but not
// how they fit together (FindMapProblems does). A row with a problem is left out and reported;
// nothing is thrown for what the file holds, and no claim of it is believed before it is backed by
// bytes. map.info.version is left empty.
Reading ReadDatabase(SQLite::Database& database, const ReadOptions& options);

}  // namespace waystone
