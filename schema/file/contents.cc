// SPDX-License-Identifier: Apache-2.0
// What must hold for the tables of a map whatever they mean: their definitions, their rows, and
// what SQLite checks itself.
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <new>
#include <string>

#include "schema/file/map_database.h"
#include "schema/file/map_tables.h"
#include "schema/tables/blob.h"
#include "schema/tables/memory.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

// Findings of integrity_check that are listed; a torn file has one for every row.
constexpr int kMaxIntegrityFindings = 1000;

struct TableContents {
  int64_t rows = 0;
  uint32_t crc = 0;

  bool operator==(const TableContents&) const = default;
};

// Our tables are named in the migrations, so no name needs more than this.
std::string Quoted(const std::string& name) { return '"' + name + '"'; }

std::string Joined(const std::vector<std::string>& names) {
  std::string joined;
  for (const std::string& name : names) joined += (joined.empty() ? "" : ", ") + Quoted(name);
  return joined;
}

// "SELECT <the columns that aren't blobs> FROM table ORDER BY <its primary key>".
std::string PlainColumnsQuery(SQLite::Database& database, const std::string& table) {
  std::vector<std::string> columns;
  std::map<int, std::string> key;
  SQLite::Statement info(database, "SELECT name, type, pk FROM pragma_table_info(?)");
  info.bind(1, table);
  while (info.executeStep()) {
    const std::string name = info.getColumn(0).getString();
    if (info.getColumn(1).getString() != "BLOB") columns.push_back(name);
    if (const int place = info.getColumn(2).getInt(); place > 0) key[place] = name;
  }
  std::vector<std::string> ordered;
  for (const auto& [place, name] : key) ordered.push_back(name);
  return "SELECT " + Joined(columns) + " FROM " + Quoted(table) + " ORDER BY " + Joined(ordered);
}

void AddValue(ValueChecksum& checksum, const SQLite::Column& column) {
  if (column.isNull()) {
    checksum.AddNull();
  } else if (column.isInteger()) {
    checksum.AddInteger(column.getInt64());
  } else if (column.isFloat()) {
    checksum.AddReal(column.getDouble());
  } else if (column.isText()) {
    checksum.AddText(column.getString());
  } else {
    checksum.AddBlob(column.getString());
  }
}

TableContents SummariseTable(SQLite::Database& database, const std::string& table) {
  SQLite::Statement rows(database, PlainColumnsQuery(database, table));
  TableContents contents;
  ValueChecksum checksum;
  while (rows.executeStep()) {
    for (int i = 0; i < rows.getColumnCount(); ++i) AddValue(checksum, rows.getColumn(i));
    ++contents.rows;
  }
  contents.crc = checksum.Value();
  return contents;
}

TableContents StoredContents(SQLite::Database& database, const std::string& table) {
  SQLite::Statement stored(database, "SELECT row_count, crc32c FROM contents WHERE table_name = ?");
  stored.bind(1, table);
  if (!stored.executeStep()) return {-1, 0};
  return {stored.getColumn(0).getInt64(), stored.getColumn(1).getUInt()};
}

void CompareContents(SQLite::Database& database, const std::string& table,
                     std::vector<MapProblem>& problems) {
  const TableContents found = SummariseTable(database, table);
  const TableContents stored = StoredContents(database, table);
  if (stored.rows < 0) {
    problems.push_back({table, "has no row in contents"});
  } else if (found.rows != stored.rows) {
    problems.push_back({table, std::to_string(found.rows) + " rows; " +
                                   std::to_string(stored.rows) + " were written"});
  } else if (found.crc != stored.crc) {
    problems.push_back({table, "its values have CRC-32C " + HexOf(found.crc) + "; " +
                                   HexOf(stored.crc) + " was written"});
  }
}

bool HasContents(const SchemaObject& object) {
  return object.type == "table" && object.name != kContentsTable.name;
}

std::vector<SchemaObject> ObjectsOf(SQLite::Database& database) {
  std::vector<SchemaObject> objects;
  SQLite::Statement rows(database,
                         "SELECT type, name, sql FROM sqlite_schema WHERE sql IS NOT NULL");
  while (rows.executeStep()) {
    objects.push_back({rows.getColumn(0).getString(), rows.getColumn(1).getString(),
                       rows.getColumn(2).getString()});
  }
  return objects;
}

void FindForeignKeyProblems(SQLite::Database& database, std::vector<MapProblem>& problems) {
  SQLite::Statement rows(database, "PRAGMA foreign_key_check");
  while (rows.executeStep()) {
    const SQLite::Column row = rows.getColumn(1);
    problems.push_back(
        {rows.getColumn(0).getString(), (row.isNull() ? "a row" : "row " + row.getString()) +
                                            " refers to a row of " + rows.getColumn(2).getString() +
                                            " that does not exist"});
  }
}

void FindIntegrityProblems(SQLite::Database& database, std::vector<MapProblem>& problems) {
  errno = 0;
  SQLite::Statement rows(database,
                         "PRAGMA integrity_check(" + std::to_string(kMaxIntegrityFindings) + ")");
  while (rows.executeStep()) {
    const std::string finding = rows.getColumn(0).getString();
    if (finding == "ok") continue;
    // A page that there was no memory for is a finding, too; malloc leaves a trace.
    if (errno == ENOMEM) throw std::bad_alloc();
    problems.push_back({"file", finding});
  }
}

// Runs one check; what SQLite can't read is a finding, too.
template <class Check>
void Guarded(const std::string& where, std::vector<MapProblem>& problems, const Check& check) {
  try {
    check();
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    problems.push_back({where, error.what()});
  }
}

}  // namespace

std::vector<SchemaObject> ExpectedObjects(std::span<const Migration> steps) {
  return WithCheckedMemory([&] {
    SQLite::Database database(":memory:", SQLite::OPEN_READWRITE);
    ApplyMigrations(database, steps, 0);
    return ObjectsOf(database);
  });
}

std::vector<MapProblem> FindAlteredObjects(SQLite::Database& database,
                                           const std::vector<SchemaObject>& expected) {
  std::vector<MapProblem> problems;
  Guarded("file", problems, [&] {
    const std::vector<SchemaObject> found = ObjectsOf(database);
    for (const SchemaObject& object : expected) {
      if (std::find(found.begin(), found.end(), object) != found.end()) continue;
      problems.push_back({object.name, "this " + object.type + " is missing or has been modified"});
    }
  });
  return problems;
}

void WriteContents(SQLite::Database& database, const std::vector<SchemaObject>& objects) {
  database.exec("DELETE FROM contents");
  RowSink sink(database);
  TableWriter<kContentsTable> writer(sink);
  for (const SchemaObject& object : objects) {
    if (!HasContents(object)) continue;
    const TableContents contents = SummariseTable(database, object.name);
    writer.Row(object.name, contents.rows, contents.crc);
  }
}

std::vector<MapProblem> FindAlteredContents(SQLite::Database& database,
                                            const std::vector<SchemaObject>& objects) {
  std::vector<MapProblem> problems;
  for (const SchemaObject& object : objects) {
    if (!HasContents(object)) continue;
    Guarded(object.name, problems, [&] { CompareContents(database, object.name, problems); });
  }
  return problems;
}

std::vector<MapProblem> FindDatabaseProblems(SQLite::Database& database) {
  std::vector<MapProblem> problems;
  Guarded("file", problems, [&] { FindIntegrityProblems(database, problems); });
  Guarded("file", problems, [&] { FindForeignKeyProblems(database, problems); });
  return problems;
}

}  // namespace waystone
