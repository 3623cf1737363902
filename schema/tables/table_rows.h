// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>

#include <string>
#include <vector>

#include "core/base/error.h"
#include "schema/file/map_store.h"
#include "schema/tables/row.h"

namespace waystone {

// Calls `read(Row&)` for every row of a table, in the order of its first `key_columns` (1 or 2)
// columns, which name the row. What `read` throws becomes a problem of that row, and what SQLite
// throws a problem of the table.
template <class Read>
void ForEachRow(SQLite::Database& database, std::vector<MapProblem>& problems, const char* table,
                const std::string& columns, int key_columns, Read read) {
  try {
    SQLite::Statement statement(database, "SELECT " + columns + " FROM " + table + " ORDER BY " +
                                              (key_columns == 1 ? "1" : "1, 2"));
    while (statement.executeStep()) {
      Row row(statement, table, key_columns);
      try {
        read(row);
      } catch (const MapError& error) {
        problems.push_back({row.Where(), error.what()});
      }
    }
  } catch (const SQLite::Exception& error) {
    problems.push_back({table, error.what()});
  }
}

}  // namespace waystone
