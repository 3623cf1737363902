// SPDX-License-Identifier: Apache-2.0
#include "quality/audit.h"

#include <iostream>
#include <memory>
#include <string>

#include "api/audit_text.h"
#include "cli/commands/commands.h"
#include "cli/files/map_file.h"

namespace waystone {
namespace {

struct AuditFlags {
  std::string map;
  bool json = false;
};

int RunAudit(const AuditFlags& flags) {
  const OpenMap map = OpenMapFile(flags.map, false);
  const AuditReport report = AuditMap(*map.index);
  if (flags.json) {
    Json json = {{"map", map.name}, {"map_version", map.index->map().info.version}};
    json.update(AuditJson(*map.index, report));
    std::cout << Dump(json) << '\n';
  } else {
    std::cout << map.name << ": " << AuditText(*map.index, report);
  }
  return 0;
}

}  // namespace

void AddAudit(CLI::App& app, Run& run) {
  auto flags = std::make_shared<AuditFlags>();
  CLI::App* command =
      app.add_subcommand("audit", "Find weak keyframes and perceptual aliases in a map");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->footer(
      "Each finding includes a recommendation.\n"
      "Example: waystone audit lab.db");
  command->callback([flags, &run] { run = [flags] { return RunAudit(*flags); }; });
}

}  // namespace waystone
