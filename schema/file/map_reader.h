// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

#include <vector>

#include "schema/file/map_store.h"
#include "schema/map_data.h"

namespace waystone {

// What could be read of a map, and problems with the rest.
struct Reading {
  MapData map;  // of the rows without a problem
  std::vector<MapProblem> problems;
};

// Reads the tables of a map of this program's version, checking every value, blob and count but not
// how they fit together (FindMapProblems does). A row with a problem is left out and reported;
// nothing is thrown for the file's contents, and no stated size is trusted before that many bytes
// are found. map.info.version is left empty. Thread-safe for different databases.
Reading ReadDatabase(SQLite::Database& database, const ReadOptions& options);

}  // namespace waystone
