// SPDX-License-Identifier: Apache-2.0
#include "schema/file/migrate.h"

#include <SQLiteCpp/Database.h>

#include <string>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "schema/file/file_replacer.h"
#include "schema/file/map_database.h"
#include "schema/tables/memory.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// A damaged map must not look sound after a migration. `steps` are those that made the map.
void CheckBefore(const fs::path& path, std::span<const Migration> steps) {
  OpenedMap opened = OpenReadOnly(path);
  const auto objects = ExpectedObjects(steps);
  std::vector<MapProblem> problems = CheckFile(opened, objects).problems;
  if (problems.empty()) problems = FindAlteredContents(opened.database, objects);
  if (problems.empty()) return;
  throw MapError(ErrorCode::kMapDamaged, path.string() + ": " + problems[0].where + ": " +
                                             problems[0].message +
                                             "; restore the map from a backup or rebuild it");
}

void ApplySteps(const fs::path& copy, std::span<const Migration> steps, int from_version) {
  SQLite::Database database = OpenForWriting(copy);
  // Recreating a table would otherwise delete the rows that refer to it.
  database.exec("PRAGMA foreign_keys = OFF");
  database.exec("BEGIN");  // after an error the file is thrown away
  ApplyMigrations(database, steps, from_version);
  WriteContents(database, ExpectedObjects(steps));
  database.exec("COMMIT");
  database.exec("VACUUM");
}

}  // namespace

int MigrateFile(const fs::path& path, std::span<const Migration> steps,
                const std::function<void(const fs::path&)>& check) {
  const MapHeader header = ReadMapHeader(path);
  const int newest = static_cast<int>(steps.size());
  if (header.schema_version == newest) return newest;
  if (header.schema_version > newest || header.schema_version < 0) {
    CheckVersion(path, header.schema_version, newest);
  }
  CheckBefore(path, steps.first(header.schema_version));
  FileReplacer file(path, true);
  try {
    fs::copy_file(path, file.temporary(), fs::copy_options::overwrite_existing);
    ApplySteps(file.temporary(), steps, header.schema_version);
  } catch (const fs::filesystem_error& error) {
    throw UnwritableError(path, error.code().message(), header.file_bytes);
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    throw UnwritableError(path, error.what(), header.file_bytes);
  }
  check(file.temporary());
  file.Commit();
  return header.schema_version;
}

}  // namespace waystone
