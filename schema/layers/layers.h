// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

#include <vector>

#include "schema/map_data.h"
#include "schema/tables/map_problem.h"
#include "schema/tables/optional_table.h"
#include "schema/tables/table.h"
#include "schema/tables/table_writer.h"

namespace waystone {

// A layer as stored in a map file.
struct StoredLayer {
  std::vector<TableView> tables;               // in the order of FORMAT.md
  std::vector<OptionalTable> optional_tables;  // the same
  // Fills the layer's part of `map`, whose info has already been read, with pictures if `images`.
  // What is wrong with a row goes to `problems`.
  void (*read)(SQLite::Database& database, bool images, MapData& map,
               std::vector<MapProblem>& problems);
  // Writes the layer where the map has it. Either all or none of its tables are optional. Throws
  // SQLite::Exception.
  void (*write)(const MapData& map, RowSink& sink);
  // Adds inconsistencies, where the map has the layer; FORMAT.md lists the rules.
  void (*find_problems)(const MapData& map, std::vector<MapProblem>& problems);
  // Whether the layer is the same in both maps.
  bool (*equal)(const MapData& a, const MapData& b);
};

// The layers of this version, in the order in which they are read and written. A new layer is added
// here and to MapData; docs/extending.md has the rest. Thread-safe.
const std::vector<StoredLayer>& StoredLayers();

// The optional tables of all layers. Thread-safe.
const std::vector<OptionalTable>& OptionalTables();

}  // namespace waystone
