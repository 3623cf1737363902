// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "builder/build_map.h"
#include "builder/joining/joinable.h"
#include "builder/joining/merge_maps.h"
#include "builder/options_record.h"
#include "builder/sources/source.h"
#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "cli/files/map_file.h"
#include "cli/output/join_text.h"
#include "cli/output/printable_output.h"
#include "cli/output/progress.h"
#include "cli/system/signals.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct AddFlags {
  std::string map;
  std::vector<std::string> sources;
  SourceOptions source;
  int to = -1;
  std::string camera;
  std::string name;
  std::string progress = "auto";
  std::vector<std::string> settings;  // of --set
  int threads = 0;
  bool keep = false;
  bool json = false;
  bool quiet = false;
};

std::vector<std::unique_ptr<Source>> OpenAdded(const AddFlags& flags) {
  SourceOptions options = flags.source;
  if (flags.to >= 0) options.to = flags.to;
  if (!flags.camera.empty()) options.camera_file = flags.camera;
  options.Check();
  std::vector<std::unique_ptr<Source>> sources;
  for (const std::string& path : flags.sources) {
    sources.push_back(OpenSource(path, options));
    if (!flags.quiet) std::cerr << path << ": " << sources.back()->Announcement() << '\n';
  }
  return sources;
}

MapData BuildAdded(const AddFlags& flags, const BuildOptions& options) {
  const std::vector<std::unique_ptr<Source>> sources = OpenAdded(flags);
  ProgressMeter meter(RawErrors(), ProgressStyleByName(flags.progress, flags.quiet),
                      ColoursWelcome());
  const auto show = [&meter](const BuildProgress& now) {
    meter.Update(
        {now.stage, now.done, now.total,
         std::to_string(now.keyframes) + " keyframes, " + std::to_string(now.planes) + " planes"});
    return !Interrupted();
  };
  MapData added = BuildMap(sources, options, show).map;
  added.info.name = flags.name.empty() ? added.sequences.front().name : flags.name;
  return added;
}

int RunAdd(const AddFlags& flags) {
  MapData map = ReadMap(flags.map);
  CheckLayersAreJoinable(map);
  BuildOptions options = OptionsOfRecord(map.info.options_json);
  options.features.type = map.info.feature_type;
  options.threads = flags.threads;
  ApplySettings(flags.settings, options);
  options.Check();
  CheckWritable(flags.map, {.overwrite = true});
  NoteInterrupts();
  MapData added = BuildAdded(flags, options);
  const JoinResult result = AddToMap(std::move(map), std::move(added), options);
  ReplaceMap(result.map, flags.map, flags.keep);
  if (flags.json) {
    std::cout << Dump(JoinJson(flags.map, result)) << '\n';
  } else if (!flags.quiet) {
    std::cout << JoinText(flags.map, result);
  }
  return 0;
}

}  // namespace

void AddAdd(CLI::App& app, Run& run) {
  auto flags = std::make_shared<AddFlags>();
  CLI::App* command = app.add_subcommand("add", "Add image sequences to a map");
  command->add_option("map", flags->map, "Map file, which is replaced")->required();
  command
      ->add_option("sources", flags->sources,
                   "Image folders, quoted globs, videos, TUM, KITTI or EuRoC sequences")
      ->required();
  command->add_option("--every", flags->source.every, "Use every N-th frame")
      ->capture_default_str();
  command->add_option("--from", flags->source.from, "Index of the first frame, starting at 0")
      ->capture_default_str();
  command->add_option("--to", flags->to, "Index of the last frame, inclusive")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--camera", flags->camera,
                      "Camera calibration: OpenCV, ROS, Kalibr or COLMAP file");
  command->add_option("--name", flags->name, "Name of the session; by default its source's");
  command->add_flag("--keep", flags->keep, "Keep the previous version as MAP.previous");
  command
      ->add_option("--threads", flags->threads,
                   "Number of threads, 0 for one per core; does not affect the map")
      ->capture_default_str();
  AddSetFlag(*command, flags->settings);
  command->add_flag("--json", flags->json, "Print the summary as one JSON object");
  command->add_flag("--quiet", flags->quiet, "Print errors only");
  command->add_option("--progress", flags->progress, "Progress on stderr: auto, none or json")
      ->capture_default_str();
  command->footer("Example: waystone add kitchen.db evening.mp4 --name evening --keep");
  command->callback([flags, &run] { run = [flags] { return RunAdd(*flags); }; });
}

}  // namespace waystone
