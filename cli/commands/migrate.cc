// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>

#include "cli/commands/commands.h"
#include "schema/file/map_lock.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

int RunMigrate(const std::string& map) {
  const MapLock lock(map);
  const int before = MigrateMap(map);
  if (before == kSchemaVersion) {
    std::cout << map << ": schema version is already " << before << "; nothing to do\n";
  } else {
    std::cout << map << ": migrated from schema version " << before << " to " << kSchemaVersion
              << '\n';
  }
  return 0;
}

}  // namespace

void AddMigrate(CLI::App& app, Run& run) {
  auto map = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("migrate", "Migrate a map to the current schema version");
  command->add_option("map", *map, "Map file")->required();
  command->footer("Example: waystone migrate lab.db");
  command->callback([map, &run] { run = [map] { return RunMigrate(*map); }; });
}

}  // namespace waystone
