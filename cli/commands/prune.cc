// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/prune_map.h"

#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "cli/files/map_file.h"
#include "cli/output/join_text.h"
#include "cli/system/signals.h"
#include "schema/file/map_lock.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct PruneFlags {
  std::string map;
  int min_looks = 3;
  std::vector<std::string> settings;  // of --set
  bool dry_run = false;
  bool keep = false;
  bool json = false;
  bool quiet = false;
};

int RunPrune(const PruneFlags& flags) {
  EndAtInterrupts();
  BuildOptions options;
  ApplySettings(flags.settings, options);
  options.Check();
  std::optional<MapLock> lock;
  if (!flags.dry_run) lock.emplace(flags.map);
  const PruneResult result = PruneMap(ReadMap(flags.map), flags.min_looks, options);
  NoteInterrupts();
  if (result.report.changed() && !flags.dry_run) ReplaceMap(result.map, flags.map, flags.keep);
  if (flags.json) {
    std::cout << Dump(PruneJson(flags.map, result)) << '\n';
  } else if (!flags.quiet) {
    std::cout << PruneText(flags.map, result);
  }
  return 0;
}

}  // namespace

void AddPrune(CLI::App& app, Run& run) {
  auto flags = std::make_shared<PruneFlags>();
  CLI::App* command = app.add_subcommand(
      "prune", "Remove features that later walks should have seen but did not find");
  command
      ->add_option("map", flags->map, "Map file, which is replaced if anything is removed from it")
      ->required();
  command
      ->add_option("--min-looks", flags->min_looks,
                   "Images of added walks that should have shown a feature before it is removed")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command->add_flag("--dry-run", flags->dry_run, "Report what would be removed and write nothing");
  command->add_flag("--keep", flags->keep, "Keep the previous version as MAP.previous");
  AddSetFlag(*command, flags->settings);
  command->add_flag("--json", flags->json, "Print the summary as one JSON object");
  command->add_flag("--quiet", flags->quiet, "Print errors only");
  command->footer("Example: waystone prune floor.db --dry-run");
  command->callback([flags, &run] { run = [flags] { return RunPrune(*flags); }; });
}

}  // namespace waystone
