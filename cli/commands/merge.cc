// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/merge_maps.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "cli/files/map_file.h"
#include "cli/files/output_file.h"
#include "cli/output/join_text.h"
#include "cli/system/signals.h"
#include "schema/file/map_lock.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct MergeFlags {
  std::vector<std::string> maps;
  std::string output;
  std::vector<std::string> settings;  // of --set
  bool force = false;
  bool json = false;
  bool quiet = false;
};

int RunMerge(const MergeFlags& flags) {
  if (flags.maps.size() < 2) {
    throw MapError(ErrorCode::kUsage, "merge joins two or more maps; name another one");
  }
  EndAtInterrupts();
  const WriteOptions write{.overwrite = flags.force};
  BuildOptions options;
  ApplySettings(flags.settings, options);
  options.Check();
  for (const std::string& path : flags.maps) {
    CheckIsNotInput(flags.output, path, "one of the maps that are joined");
  }
  CheckWritable(flags.output, write);
  const MapLock lock(flags.output);
  std::vector<MapData> maps;
  for (const std::string& path : flags.maps) {
    maps.push_back(ReadMap(path));
    maps.back().info.name = MapNameOf(path);
  }
  const JoinResult result = MergeMaps(std::move(maps), MapNameOf(flags.output), options);
  NoteInterrupts();
  WriteMap(result.map, flags.output, write);
  if (flags.json) {
    std::cout << Dump(JoinJson(flags.output, result)) << '\n';
  } else if (!flags.quiet) {
    std::cout << JoinText(flags.output, result);
  }
  return 0;
}

}  // namespace

void AddMerge(CLI::App& app, Run& run) {
  auto flags = std::make_shared<MergeFlags>();
  CLI::App* command = app.add_subcommand("merge", "Join maps that were built apart");
  command->add_option("maps", flags->maps, "Map files, two or more; their order does not matter")
      ->required();
  command->add_option("-o,--output", flags->output, "Output map file")->required();
  AddSetFlag(*command, flags->settings);
  command->add_flag("--force", flags->force,
                    "Overwrite an existing map file; no other file is overwritten");
  command->add_flag("--json", flags->json, "Print the summary as one JSON object");
  command->add_flag("--quiet", flags->quiet, "Print errors only");
  command->footer("Example: waystone merge east.db west.db -o floor.db");
  command->callback([flags, &run] { run = [flags] { return RunMerge(*flags); }; });
}

}  // namespace waystone
