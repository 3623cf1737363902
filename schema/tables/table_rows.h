// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>

#include <string>
#include <vector>

#include "core/base/error.h"
#include "schema/tables/map_problem.h"
#include "schema/tables/memory.h"
#include "schema/tables/row.h"

namespace waystone {

// Calls `read(Row&)` for every row of a table, in the order of its primary key. A MapError thrown
// by `read` becomes a problem of that row, and SQLite's exceptions a problem of the table. `read`
// reads all columns of the descriptor (WS_CHECK). Throws std::bad_alloc. Thread-safe for different
// databases.
template <class Read>
void ForEachRow(SQLite::Database& database, std::vector<MapProblem>& problems,
                const TableView& table, Read read) {
  const std::string name(table.name);
  try {
    SQLite::Statement statement(database, "SELECT " + ColumnList(table) + " FROM " + name +
                                              " ORDER BY " +
                                              (table.key_columns == 1 ? "1" : "1, 2"));
    while (statement.executeStep()) {
      Row row(statement, table);
      try {
        read(row);
        row.CheckComplete();
      } catch (const MapError& error) {
        CheckMemory(database);
        problems.push_back({row.Where(), error.what()});
      }
    }
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    problems.push_back({name, error.what()});
  }
}

// The same for a table of a layer that a map may lack: its rows are problems where the row of
// `layer` wasn't found.
template <class Read>
void ForEachRowOfLayer(SQLite::Database& database, std::vector<MapProblem>& problems,
                       const TableView& table, const TableView& layer, const bool& found,
                       Read read) {
  ForEachRow(database, problems, table, [&](Row& row) {
    if (!found && table.name != layer.name) {
      throw MapError(ErrorCode::kMapDamaged, std::string(layer.name) + " has no row");
    }
    read(row);
  });
}

}  // namespace waystone
