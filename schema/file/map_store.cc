// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_store.h"

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "core/base/text.h"
#include "schema/file/file_replacer.h"
#include "schema/file/map_database.h"
#include "schema/file/map_problems.h"
#include "schema/file/map_reader.h"
#include "schema/file/map_writer.h"
#include "schema/file/migrate.h"
#include "schema/file/sha256.h"
#include "schema/layers/layers.h"
#include "schema/tables/memory.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// What maps of this version consist of; the same for the life of the program.
const std::vector<SchemaObject>& CurrentObjects() {
  static const std::vector<SchemaObject> objects = ExpectedObjects(Migrations());
  return objects;
}

void Append(std::vector<MapProblem>& to, std::vector<MapProblem> from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

// Reads a file that may be damaged and reports everything that is wrong with it: the single entry
// point, for both reading and checking. Throws MapError when it can't be opened as a map of this
// version.
Reading Inspect(const fs::path& path, const ReadOptions& options) {
  OpenedMap opened = OpenReadOnly(path);
  CheckVersion(path, opened.header.schema_version, kSchemaVersion);
  auto [problems, readable] = CheckFile(opened, CurrentObjects());
  WS_CHECK(readable || !problems.empty(), "an unreadable map without a problem");
  if (!readable) return {{}, std::move(problems)};
  Append(problems, FindUnusedPages(opened));
  Reading reading = ReadDatabase(opened.database, options);
  Append(problems, std::move(reading.problems));
  Append(problems, FindAlteredContents(opened.database, CurrentObjects()));
  Append(problems, FindMapProblems(reading.map));
  reading.problems = std::move(problems);
  if (reading.problems.empty()) reading.map.info.version = Sha256(opened.bytes);
  return reading;
}

std::string Summary(const std::vector<MapProblem>& problems) {
  std::string text = problems[0].where + ": " + problems[0].message;
  if (problems.size() > 1) text += " (and " + std::to_string(problems.size() - 1) + " more)";
  return text;
}

[[noreturn]] void ThrowDamaged(const fs::path& path, const std::vector<MapProblem>& problems) {
  throw MapError(
      ErrorCode::kMapDamaged,
      path.string() + " is damaged: " + Summary(problems) +
          "; restore it from a backup or rebuild it (`waystone check` lists all problems)");
}

bool SameMap(const MapData& a, const MapData& b) {
  return a.info.name == b.info.name && a.info.program == b.info.program &&
         a.info.feature_type == b.info.feature_type && a.info.options_json == b.info.options_json &&
         a.sequences == b.sequences &&
         std::ranges::all_of(StoredLayers(),
                             [&](const StoredLayer& layer) { return layer.equal(a, b); });
}

void VerifyWritten(const MapData& map, const fs::path& written, const fs::path& target) {
  const Reading reading = Inspect(written, {});
  if (reading.problems.empty() && SameMap(map, reading.map)) return;
  throw MapError(ErrorCode::kMapDamaged,
                 target.string() + ": the written file reads back " +
                     (reading.problems.empty() ? "differently" : Summary(reading.problems)) +
                     "; the target was not replaced; check the disk and try again");
}

std::map<std::string, int64_t> BytesByTable(SQLite::Database& database) {
  std::map<std::string, int64_t> bytes;
  SQLite::Statement rows(database,
                         "SELECT coalesce(s.tbl_name, d.name), sum(d.pgsize) FROM dbstat d "
                         "LEFT JOIN sqlite_schema s ON s.name = d.name "
                         "WHERE d.aggregate = TRUE GROUP BY 1");
  while (rows.executeStep()) bytes[rows.getColumn(0).getString()] = rows.getColumn(1).getInt64();
  return bytes;
}

// For an SQLite without dbstat: the size of the columns' values, without page overhead.
int64_t BytesOfColumns(SQLite::Database& database, const std::string& table) {
  std::string sum = "0";
  SQLite::Statement columns(database, "SELECT name FROM pragma_table_info(?)");
  columns.bind(1, table);
  while (columns.executeStep()) {
    sum += " + coalesce(length(CAST(" + columns.getColumn(0).getString() + " AS BLOB)), 0)";
  }
  return database.execAndGet("SELECT coalesce(sum(" + sum + "), 0) FROM " + table).getInt64();
}

std::vector<TableSize> SizesOf(SQLite::Database& database) {
  const bool dbstat = HasDbstat();
  std::map<std::string, int64_t> bytes;
  if (dbstat) bytes = BytesByTable(database);
  std::vector<TableSize> sizes;
  for (const SchemaObject& object : WithOptionalObjects(database, CurrentObjects())) {
    if (object.type != "table") continue;
    const int64_t rows = database.execAndGet("SELECT count(*) FROM " + object.name).getInt64();
    sizes.push_back(
        {object.name, rows, dbstat ? bytes[object.name] : BytesOfColumns(database, object.name)});
  }
  if (dbstat) {
    const int64_t rows = database.execAndGet("SELECT count(*) FROM sqlite_schema").getInt64();
    sizes.push_back({"sqlite_schema", rows, bytes["sqlite_schema"]});
  }
  return sizes;
}

// Throws kFileExists for a file that isn't a map.
void CheckReplacesMap(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return;
  try {
    ReadMapHeader(path);
  } catch (const MapError& error) {
    throw MapError(ErrorCode::kFileExists, std::string(error.what()) +
                                               "; only maps are overwritten, so choose another "
                                               "name or remove the file");
  }
}

void CheckSound(const MapData& map, const fs::path& path) {
  const std::vector<MapProblem> problems = FindMapProblems(map);
  if (problems.empty()) return;
  throw MapError(ErrorCode::kMapDamaged, path.string() +
                                             " was not written because the map is inconsistent: " +
                                             Summary(problems) + "; please report this");
}

// Copies the file that a map was read from.
void CopyRead(const MapData& map, const fs::path& from, const fs::path& to) {
  fs::copy_file(from, to, fs::copy_options::overwrite_existing);
  if (Sha256(OpenReadOnly(to).bytes) == map.info.version) return;
  throw MapError(ErrorCode::kFileUnreadable,
                 from.string() + " was replaced by another program meanwhile; try again");
}

void ReplaceOptionalTables(const MapData& map, const fs::path& copy) {
  SQLite::Database database = OpenForWriting(copy);
  database.exec("BEGIN");  // after an error the file is thrown away
  RowSink sink(database);
  for (const StoredLayer& layer : StoredLayers()) {
    if (layer.optional_tables.empty()) continue;
    for (const OptionalTable& table : layer.optional_tables) {
      database.exec("DROP TABLE IF EXISTS " + std::string(table.table.name));
    }
    layer.write(map, sink);
  }
  WriteContents(database, CurrentObjects());
  database.exec("COMMIT");
  database.exec("VACUUM");
}

}  // namespace

void CheckWritable(const fs::path& path, const WriteOptions& options) {
  const FileReplacer probe(path, options.overwrite);  // is removed again
  CheckReplacesMap(path);
}

void WriteMap(const MapData& map, const fs::path& path, const WriteOptions& options) {
  CheckSound(map, path);
  try {
    FileReplacer file(path, options.overwrite);
    CheckReplacesMap(path);
    WriteDatabase(map, file.temporary());
    VerifyWritten(map, file.temporary(), path);
    file.Commit();
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    // The temporary file is already removed, so the free space is complete.
    throw UnwritableError(path, error.what(), EstimateBytes(map));
  }
}

void RewriteOptionalTables(const MapData& map, const fs::path& path) {
  CheckSound(map, path);
  try {
    FileReplacer file(path, true);
    CopyRead(map, path, file.temporary());
    ReplaceOptionalTables(map, file.temporary());
    VerifyWritten(map, file.temporary(), path);
    file.Commit();
  } catch (const fs::filesystem_error& error) {
    throw UnwritableError(path, error.code().message(), EstimateBytes(map));
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    throw UnwritableError(path, error.what(), EstimateBytes(map));
  }
}

MapData ReadMap(const fs::path& path, const ReadOptions& options) {
  Reading reading = Inspect(path, options);
  if (!reading.problems.empty()) ThrowDamaged(path, reading.problems);
  return std::move(reading.map);
}

std::vector<MapProblem> CheckMap(const fs::path& path) { return Inspect(path, {}).problems; }

std::vector<TableSize> TableSizes(const fs::path& path) {
  OpenedMap map = OpenReadOnly(path);
  CheckVersion(path, map.header.schema_version, kSchemaVersion);
  const FileCheck check = CheckFile(map, CurrentObjects());
  if (!check.readable) ThrowDamaged(path, check.problems);
  try {
    return SizesOf(map.database);
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    ThrowDamaged(path, {{"file", Printable(error.what())}});
  }
}

int MigrateMap(const fs::path& path) {
  return MigrateFile(path, Migrations(), [&](const fs::path& migrated) {
    const std::vector<MapProblem> problems = CheckMap(migrated);
    if (!problems.empty()) ThrowDamaged(path, problems);
  });
}

}  // namespace waystone
