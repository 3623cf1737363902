// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/files/map_writes.h"

#include <set>
#include <string>

#include "schema/file/map_database.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

// Small, for there are hundreds of writes of it.
const MapShape kSmall{.keyframes = 4, .planes = 2, .max_features = 8, .max_landmarks = 0};

// Takes away what versions after the first brought.
void MakeVersionOne(const std::filesystem::path& path) {
  std::set<std::string> kept;
  for (const SchemaObject& object : ExpectedObjects(Migrations().first(1)))
    kept.insert(object.name);
  for (const SchemaObject& object : ExpectedObjects(Migrations())) {
    if (kept.contains(object.name)) continue;
    RunSql(path, "DROP " + object.type + " " + object.name);
    RunSql(path, "DELETE FROM contents WHERE table_name = '" + object.name + "'");
  }
  RunSql(path, "PRAGMA user_version = 1; VACUUM");
}

}  // namespace

MapWrite Overwrite() {
  return {"overwrite",
          [](const TemporaryFolder& folder) { WriteMap(MadeMap(71, kSmall), folder / "m.db", {}); },
          [](const TemporaryFolder& folder) {
            WriteMap(MadeMap(72, kSmall), folder / "m.db", {.overwrite = true});
          }};
}

MapWrite Migrate() {
  return {"migrate",
          [](const TemporaryFolder& folder) {
            WriteMap(MadeMap(71, kSmall), folder / "m.db", {});
            MakeVersionOne(folder / "m.db");
          },
          [](const TemporaryFolder& folder) { MigrateMap(folder / "m.db"); }};
}

}  // namespace waystone
