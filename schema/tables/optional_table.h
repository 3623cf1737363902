// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

#include <optional>
#include <string>
#include <vector>

#include "schema/tables/table.h"
#include "schema/tables/table_rows.h"
#include "schema/tables/table_writer.h"

namespace waystone {

// A table that only maps with contents for it have. Its definition is plain
// (schema/file/plain_objects.h), so that programs that don't know it leave it alone.
struct OptionalTable {
  TableView table;
  const char* sql;  // CREATE TABLE, as sqlite_schema has it
};

// As ForEachRow, where the map has the table. Thread-safe for different databases.
template <class Read>
void ForEachOptionalRow(SQLite::Database& database, std::vector<MapProblem>& problems,
                        const TableView& table, Read read) {
  const std::string name(table.name);
  try {
    if (!database.tableExists(name)) return;
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    problems.push_back({name, error.what()});
    return;
  }
  ForEachRow(database, problems, table, read);
}

// Writes rows of such a table, which is created before the first of them. Not thread-safe.
template <const auto& kTable>
class OptionalTableWriter {
 public:
  OptionalTableWriter(RowSink& sink, const char* sql) : sink_(sink), sql_(sql) {}

  template <class... Values>
  void Row(const Values&... values) {
    if (!writer_) {
      if (sink_.database()) sink_.database()->exec(sql_);
      writer_.emplace(sink_);
    }
    writer_->Row(values...);
  }

 private:
  RowSink& sink_;
  const char* sql_;
  std::optional<TableWriter<kTable>> writer_;
};

}  // namespace waystone
