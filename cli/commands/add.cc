// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "builder/joining/joinable.h"
#include "builder/joining/merge_maps.h"
#include "cli/commands/build_sources.h"
#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "cli/files/given_poses.h"
#include "cli/files/map_file.h"
#include "cli/output/join_text.h"
#include "cli/system/signals.h"
#include "schema/file/map_lock.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct AddFlags {
  std::string map;
  SourceFlags sources;
  PoseFlags poses;
  std::string name;
  std::vector<std::string> settings;  // of --set
  int threads = 0;
  bool keep = false;
  BuildOutputFlags printed;
};

int RunAdd(const AddFlags& flags) {
  EndAtInterrupts();
  const MapLock lock(flags.map);
  MapData map = ReadMap(flags.map);
  BuildOptions options = OptionsOfMap(map);
  options.threads = flags.threads;
  ApplySettings(flags.settings, options);
  options.Check();
  CheckOptionsFit(map, options);
  CheckReplaceable(flags.map, flags.keep);
  const auto sources = OpenSources(flags.sources, options.layers, flags.printed.quiet);
  std::optional<GivenPoses> poses;
  if (!flags.poses.file.empty()) {
    poses = ReadGivenPoses(flags.poses, static_cast<int>(sources.size()));
  }
  BuildResult built =
      BuildWithProgress(sources, options, flags.printed, poses, BuiltFeatures::kKeep);
  MapData added = std::move(built.map);
  if (!HasPlanesOrLandmarks(added) && !added.appearance && !added.orientation) {
    return ReportNoPlanes(added);
  }
  added.info.name = flags.name.empty() ? added.sequences.front().name : flags.name;
  const JoinResult result = AddToMap(std::move(map), std::move(added), options, built.features);
  NoteInterrupts();
  ReplaceMap(result.map, flags.map, flags.keep);
  if (flags.printed.json) {
    std::cout << Dump(JoinJson(flags.map, result)) << '\n';
  } else if (!flags.printed.quiet) {
    std::cout << JoinText(flags.map, result);
  }
  return 0;
}

}  // namespace

void AddAdd(CLI::App& app, Run& run) {
  auto flags = std::make_shared<AddFlags>();
  CLI::App* command = app.add_subcommand("add", "Add image sequences to a map");
  command->add_option("map", flags->map, "Map file, which is replaced")->required();
  AddSourceFlags(
      *command,
      "Image folders, quoted globs, videos, panoramas, rigs, TUM, KITTI or EuRoC sequences",
      flags->sources);
  AddPoseFlags(*command, flags->poses);
  command->add_option("--name", flags->name, "Name of the session; by default its source's");
  command->add_flag("--keep", flags->keep, "Keep the previous version as MAP.previous");
  AddThreadsFlag(*command, flags->threads);
  AddSetFlag(*command, flags->settings);
  AddBuildOutputFlags(*command, flags->printed);
  command->footer("Example: waystone add kitchen.db evening.mp4 --name evening --keep");
  command->callback([flags, &run] { run = [flags] { return RunAdd(*flags); }; });
}

}  // namespace waystone
