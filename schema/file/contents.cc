// SPDX-License-Identifier: Apache-2.0
// What must hold for the tables of a map whatever they mean: their definitions, their rows, and
// what SQLite checks itself.
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <new>
#include <sstream>
#include <string>
#include <string_view>

#include "core/base/text.h"
#include "schema/file/map_database.h"
#include "schema/file/map_tables.h"
#include "schema/file/plain_objects.h"
#include "schema/layers/layers.h"
#include "schema/tables/blob.h"
#include "schema/tables/memory.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

// The most findings of integrity_check that are listed; a torn file has one per row.
constexpr int kMaxIntegrityFindings = 1000;
// The prefix of its findings about pages, all of which are in its first row.
constexpr std::string_view kPageFindings = "*** in database";
// The page of this byte holds nothing: SQLite locks it (https://www.sqlite.org/fileformat2.html).
constexpr int64_t kLockByte = 0x40000000;
// How many SQLite instructions checking and reading may take: many times the 3 per byte that maps
// with the smallest rows need.
constexpr int64_t kLeastSteps = 10'000'000;
constexpr int64_t kStepsPerByte = 50;

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

// The table may be missing if it was also missing when `contents` was filled.
void CompareOptionalContents(SQLite::Database& database, const std::string& table,
                             std::vector<MapProblem>& problems) {
  if (database.tableExists(table)) {
    CompareContents(database, table, problems);
  } else if (StoredContents(database, table).rows >= 0) {
    problems.push_back({table, "this table is missing"});
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
    problems.push_back({Printable(rows.getColumn(0).getString()),
                        (row.isNull() ? "a row" : "row " + row.getString()) +
                            " refers to a row of " + Printable(rows.getColumn(2).getString()) +
                            " that does not exist"});
  }
}

void AddLines(const std::string& findings, std::vector<MapProblem>& problems) {
  std::istringstream lines(findings);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(kPageFindings)) problems.push_back({"file", Printable(line)});
  }
}

// Returns whether the pages can be read. If not, it ends with the first row, since the rest of the
// check would walk the pages, too.
bool FindIntegrityProblems(SQLite::Database& database, std::vector<MapProblem>& problems) {
  errno = 0;
  SQLite::Statement rows(database,
                         "PRAGMA integrity_check(" + std::to_string(kMaxIntegrityFindings) + ")");
  while (rows.executeStep()) {
    const std::string finding = rows.getColumn(0).getString();
    if (finding == "ok") continue;
    // Pages for which there was no memory are also reported as findings, but malloc sets errno.
    if (errno == ENOMEM) throw std::bad_alloc();
    AddLines(finding, problems);
    if (finding.starts_with(kPageFindings)) return false;
  }
  return true;
}

// Runs one check; if SQLite can't read something, that is a finding, too. Returns whether it could.
template <class Check>
bool Guarded(const std::string& where, std::vector<MapProblem>& problems, const Check& check) {
  try {
    check();
    return true;
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    const bool too_long = error.getErrorCode() == SQLITE_INTERRUPT;  // by the count of steps
    problems.push_back({where, too_long ? "holds more objects or rows than its size accounts for"
                                        : Printable(error.what())});
    return false;
  }
}

bool Contains(const std::vector<SchemaObject>& objects, const SchemaObject& object) {
  return std::ranges::find(objects, object) != objects.end();
}

std::vector<SchemaObject> OptionalObjects() {
  std::vector<SchemaObject> objects;
  for (const auto& [table, sql] : OptionalTables()) {
    objects.push_back({"table", std::string(table.name), sql});
  }
  return objects;
}

bool IsOptionalName(const std::string& name) {
  return std::ranges::any_of(OptionalTables(),
                             [&](const OptionalTable& one) { return one.table.name == name; });
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
      if (Contains(found, object)) continue;
      problems.push_back({object.name, "this " + object.type + " is missing or has been modified"});
    }
    const std::vector<SchemaObject> optional = OptionalObjects();
    for (const SchemaObject& object : found) {
      if (Contains(expected, object) || Contains(optional, object)) continue;
      if (IsOptionalName(object.name)) {
        problems.push_back({object.name, "this " + Printable(object.type) +
                                             " has the name of a table of Waystone's and another "
                                             "definition; rename it"});
        continue;
      }
      if (IsPlainObject(object)) continue;
      problems.push_back({Printable(object.name), "this " + Printable(object.type) +
                                                      " is not part of a map; drop it (only plain "
                                                      "tables and indexes may be added)"});
    }
  });
  return problems;
}

std::vector<SchemaObject> WithOptionalObjects(SQLite::Database& database,
                                              std::vector<SchemaObject> objects) {
  const std::vector<SchemaObject> found = ObjectsOf(database);
  for (const SchemaObject& object : OptionalObjects()) {
    if (Contains(found, object)) objects.push_back(object);
  }
  return objects;
}

void WriteContents(SQLite::Database& database, const std::vector<SchemaObject>& objects) {
  database.exec("DELETE FROM contents");
  RowSink sink(database);
  TableWriter<kContentsTable> writer(sink);
  for (const SchemaObject& object : WithOptionalObjects(database, objects)) {
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
  if (objects.empty()) return problems;  // an empty database has no table `contents`
  for (const SchemaObject& object : OptionalObjects()) {
    Guarded(object.name, problems,
            [&] { CompareOptionalContents(database, object.name, problems); });
  }
  return problems;
}

bool HasDbstat() { return sqlite3_compileoption_used("ENABLE_DBSTAT_VTAB") != 0; }

// SQLite 3.40's integrity_check leaves them out where a view comes first among the tables.
std::vector<MapProblem> FindUnusedPages(OpenedMap& map) {
  std::vector<MapProblem> problems;
  int64_t unused = map.header.free_pages;
  Guarded("file", problems, [&] {
    if (!HasDbstat() || unused > 0) return;
    const int64_t used =
        map.database.execAndGet("SELECT sum(pgsize) FROM dbstat WHERE aggregate = TRUE").getInt64();
    const int64_t page_bytes = map.database.execAndGet("PRAGMA page_size").getInt64();
    unused = (map.header.claimed_bytes - used) / page_bytes;
    if (map.header.claimed_bytes > kLockByte) --unused;
  });
  if (unused > 0) {
    problems.push_back(
        {"file", "has " + std::to_string(unused) +
                     " unused pages; run `sqlite3 FILE 'PRAGMA auto_vacuum = 0; VACUUM'` on it"});
  }
  return problems;
}

FileCheck CheckFile(OpenedMap& map, const std::vector<SchemaObject>& expected) {
  FileCheck check;
  if (const auto cut = FindCut(map.header)) check.problems.push_back(*cut);
  if (!check.problems.empty()) return check;
  check.problems = FindAlteredObjects(map.database, expected);
  if (!check.problems.empty()) return check;
  *map.steps_left = kLeastSteps + kStepsPerByte * map.header.file_bytes;
  bool sound_pages = false;
  Guarded("file", check.problems,
          [&] { sound_pages = FindIntegrityProblems(map.database, check.problems); });
  if (!sound_pages) return check;
  check.readable = Guarded("file", check.problems,
                           [&] { FindForeignKeyProblems(map.database, check.problems); });
  return check;
}

}  // namespace waystone
