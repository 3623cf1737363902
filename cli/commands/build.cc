// SPDX-License-Identifier: Apache-2.0
#include "builder/build_map.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/query_request_json.h"
#include "builder/report/report.h"
#include "cli/commands/build_sources.h"
#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "cli/files/given_poses.h"
#include "cli/files/kept_names.h"
#include "cli/files/kept_plans.h"
#include "cli/files/map_file.h"
#include "cli/files/panorama_file.h"
#include "cli/output/build_text.h"
#include "cli/system/signals.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct BuildFlags {
  SourceFlags sources;
  std::string output;
  std::string report_folder;
  std::string features = "sift";
  std::string layers = "auto";
  std::vector<std::string> settings;  // of --set
  PanoramaFlags panorama;
  PoseFlags poses;
  BuildOptions build;
  bool no_images = false;
  bool force = false;
  BuildOutputFlags printed;
};

BuildOptions MakeBuildOptions(const BuildFlags& flags) {
  BuildOptions options = flags.build;
  options.map_name = MapNameOf(flags.output);
  options.features.type = FeatureTypeByName(flags.features);
  options.images = !flags.no_images;
  options.layers = LayerChoiceByNames(flags.layers);
  options.appearance.describe.panorama = PanoramaOptionsOf(flags.panorama);
  options.appearance.describe.signature.band = SignatureOptionsOf(flags.panorama).band;
  ApplySettings(flags.settings, options);
  options.Check();
  return options;
}

BuildResult BuildFrom(const BuildFlags& flags, const BuildOptions& options) {
  std::optional<GivenPoses> poses;
  if (!flags.poses.file.empty()) {
    poses = ReadGivenPoses(flags.poses, static_cast<int>(flags.sources.paths.size()));
  }
  return BuildWithProgress(OpenSources(flags.sources, options.layers, flags.printed.quiet), options,
                           flags.printed, poses);
}

void PrintSummary(const BuildFlags& flags, const BuildResult& result) {
  BuildSummary summary;
  summary.path = flags.output;
  summary.version = ReadMap(flags.output, {.images = false}).info.version;
  summary.bytes = std::filesystem::file_size(flags.output);
  summary.tables = TableSizes(flags.output);
  summary.result = &result;
  if (flags.printed.json) {
    std::cout << Dump(SummaryJson(summary)) << '\n';
  } else if (!flags.printed.quiet) {
    std::cout << SummaryText(summary);
  }
}

void KeepOldNames(const std::string& names, const std::string& path, MapData& map) {
  const std::optional<std::filesystem::path> kept_apart = KeepNames(names, path, map);
  if (!kept_apart) return;
  std::cerr << "waystone: the new map has only some of the named places of the old one; all are in "
            << kept_apart->string() << " (waystone name " << path << " --from FILE lists them)\n";
}

void KeepOldPlans(const KeptPlans& plans, const std::string& path, MapData& map) {
  for (const PlanApart& apart : KeepPlans(plans, path, map)) {
    std::cerr << "waystone: the floor plan " << Printable(QuoteShortened(apart.name))
              << " is not in the new map: it was anchored " << Printable(apart.cause)
              << "; its image is in " << apart.image.string() << " (waystone plan " << path
              << " IMAGE --anchor ... takes it again)\n";
  }
}

int RunBuild(const BuildFlags& flags) {
  const WriteOptions write{.overwrite = flags.force};
  const BuildOptions options = MakeBuildOptions(flags);
  CheckWritable(flags.output, write);
  if (!flags.report_folder.empty()) CheckReportFolder(flags.report_folder);
  const std::optional<std::string> names = NamesOfOldMap(flags.output);
  const std::optional<KeptPlans> plans = PlansOfOldMap(flags.output);
  NoteInterrupts();
  BuildResult result = BuildFrom(flags, options);
  const bool directions_alone = result.map.orientation && !result.report.planes;
  if (!HasPlanesOrLandmarks(result.map) && !result.map.appearance && !directions_alone) {
    return ReportNoPlanes(result.map);
  }
  if (names) KeepOldNames(*names, flags.output, result.map);
  if (plans) KeepOldPlans(*plans, flags.output, result.map);
  WriteMap(result.map, flags.output, write);
  if (!flags.report_folder.empty()) {
    WriteReport(result.map, result.report, TableSizes(flags.output), flags.report_folder);
  }
  PrintSummary(flags, result);
  return 0;
}

void AddMapFlags(CLI::App* command, BuildFlags& flags) {
  command->add_option("--features", flags.features, "Feature type: sift, orb or akaze")
      ->capture_default_str();
  command
      ->add_option("--max-features", flags.build.features.max_features,
                   "Maximum features per image")
      ->capture_default_str();
  command
      ->add_option("--landmarks", flags.build.planes.landmarks.max_kept,
                   "Maximum features per keyframe beside the planes; 0 keeps planes only")
      ->capture_default_str();
  command
      ->add_option("--layers", flags.layers,
                   "Comma-separated layers: planes, appearance (panoramas), orientation (rigs, "
                   "panoramas, calibrated cameras); auto chooses by the type of the source, with "
                   "orientation for rigs and panoramas only")
      ->capture_default_str();
  command
      ->add_option(
          "--max-loss", flags.build.appearance.redundancy.max_loss,
          "Drop redundant panoramas whose loss of information is at most this share, 0 to 1")
      ->capture_default_str();
  command
      ->add_option(
          "--node-features", flags.build.appearance.describe.features.max_kept,
          "Features stored per panorama, 36 bytes each, for verification and for localizing "
          "photos; 0 stores none")
      ->capture_default_str();
  AddPanoramaFlags(*command, flags.panorama);
  command->add_flag("--no-images", flags.no_images, "Do not store keyframe images in the map");
  AddThreadsFlag(*command, flags.build.threads);
  AddSetFlag(*command, flags.settings);
  command->add_flag("--force", flags.force,
                    "Overwrite an existing map file; no other file is overwritten");
}

}  // namespace

void AddBuild(CLI::App& app, Run& run) {
  auto flags = std::make_shared<BuildFlags>();
  CLI::App* command = app.add_subcommand("build", "Build a map from image sequences");
  AddSourceFlags(*command,
                 "Image folders, quoted globs, videos, TUM, KITTI or EuRoC sequences, "
                 "panorama folders or rig folders",
                 flags->sources);
  command->add_option("-o,--output", flags->output, "Output map file")->required();
  AddPoseFlags(*command, flags->poses);
  AddMapFlags(command, *flags);
  command->add_option("--report", flags->report_folder, "Write an HTML report to this folder");
  AddBuildOutputFlags(*command, flags->printed);
  command->footer(
      "Example: waystone build kitchen.mp4 -o kitchen.db --report kitchen-report\n"
      "         waystone build panoramas/ -o lab.db --layers appearance\n"
      "         waystone build walk/ -o walk.db --camera cam.yaml --layers planes,orientation");
  command->callback([flags, &run] { run = [flags] { return RunBuild(*flags); }; });
}

}  // namespace waystone
