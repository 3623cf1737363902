// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/files/map_file.h"
#include "cli/files/query_set.h"
#include "cli/output/eval_text.h"
#include "cli/output/printable_output.h"
#include "cli/output/progress.h"
#include "core/base/error.h"
#include "localizer/localizer.h"
#include "quality/evaluation.h"

namespace waystone {
namespace {

struct EvalFlags {
  std::string map;
  std::vector<std::string> queries;
  std::vector<std::string> negatives;
  std::string poses;
  std::string truth;
  bool json = false;
  bool quiet = false;
};

std::vector<LabelledQuery> ReadQueries(const EvalFlags& flags, const MapIndex& index,
                                       const PlacePoses& places) {
  if (flags.queries.empty() && flags.negatives.empty()) {
    throw MapError(ErrorCode::kUsage, "no queries; specify a CSV file or --negatives DIR");
  }
  std::vector<LabelledQuery> all;
  const auto add = [&all](std::vector<LabelledQuery> more) {
    std::move(more.begin(), more.end(), std::back_inserter(all));
  };
  for (const std::string& path : flags.queries) {
    if (!std::filesystem::is_directory(path)) {
      add(ReadQuerySet(path, index));
      continue;
    }
    if (flags.truth.empty()) {
      throw MapError(ErrorCode::kUsage, path +
                                            " is a folder; specify the poses of its images with "
                                            "--truth FILE, or use a CSV file of queries");
    }
    add(ReadPosedImages(path, ImagePoses(ReadPoseFile(flags.truth)), places,
                        kTolerances.back()[0]));
  }
  for (const std::string& folder : flags.negatives) add(ReadNegatives(folder));
  return all;
}

// Without rotations of the map's images, no angle of an answer can be measured.
bool HaveRotations(const PlacePoses& places) {
  return std::ranges::any_of(places, [](const auto& place) { return place.second.has_rotation; });
}

ScoredQuery Ask(const OpenMap& map, const LabelledQuery& query, const PlacePoses& places) {
  ScoredQuery scored;
  scored.truth = query.truth;
  scored.answer = Localize(*map.index, ReadBytes(query.image), query.image.string(), {});
  if (!query.pose) return scored;
  scored.has_true_angle = query.pose->has_rotation && HaveRotations(places);
  const auto metres_per_unit = MetresPerUnit(map.index->map(), places);
  scored.error =
      ComparePose(scored.answer, places, metres_per_unit, *query.pose, map.index->map().poses);
  return scored;
}

// One after the other: the times are those of a query that has the machine to itself.
std::vector<ScoredQuery> AskAll(const OpenMap& map, const std::vector<LabelledQuery>& queries,
                                const PlacePoses& places, bool quiet) {
  ProgressMeter meter(RawErrors(), ProgressStyleByName("auto", quiet), ColoursWelcome());
  std::vector<ScoredQuery> scored;
  for (const LabelledQuery& query : queries) {
    scored.push_back(Ask(map, query, places));
    meter.Update(
        {"queries", static_cast<int>(scored.size()), static_cast<int>(queries.size()), ""});
  }
  return scored;
}

int RunEval(const EvalFlags& flags) {
  if (flags.map.empty()) {
    throw MapError(ErrorCode::kUsage, "map is required; see waystone eval --help");
  }
  const OpenMap map = OpenMapFile(flags.map, false);
  const std::string& of_map = flags.poses.empty() ? flags.truth : flags.poses;
  const PlacePoses places = of_map.empty()
                                ? PosesOfLayer(map.index->map())
                                : PosesOfPlaces(ImagePoses(ReadPoseFile(of_map)), *map.index);
  const std::vector<LabelledQuery> queries = ReadQueries(flags, *map.index, places);
  const std::vector<ScoredQuery> scored = AskAll(map, queries, places, flags.quiet);
  const Evaluation evaluation = Evaluate(*map.index, scored);
  if (flags.json) {
    Json json = {{"map", map.name}, {"map_version", map.index->map().info.version}};
    json.update(EvaluationJson(evaluation));
    json["failures"] = FailuresJson(*map.index, scored);
    std::cout << Dump(json) << '\n';
  } else {
    std::cout << map.name << ", " << EvaluationText(evaluation) << MistakesText(*map.index, scored);
  }
  return 0;
}

}  // namespace

void AddEval(CLI::App& app, Run& run) {
  auto flags = std::make_shared<EvalFlags>();
  CLI::App* command =
      app.add_subcommand("eval", "Evaluate localization with a map on labelled photos");
  command->add_option("map", flags->map, "Map file");  // not required: its subcommand has no map
  command->add_option("queries", flags->queries,
                      "CSV files with columns image and keyframe or frame, optionally x, y, z, qx, "
                      "qy, qz, qw; or folders of images, with --truth");
  command
      ->add_option("--negatives", flags->negatives,
                   "Folder of images that are not in the map; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--poses", flags->poses,
                      "Poses of the map's images: TUM, KITTI, EuRoC, COLMAP (images.txt or "
                      "images.bin), g2o, ROS nav_msgs/Odometry as CSV, or CSV");
  command->add_option("--truth", flags->truth,
                      "Poses of the images of query folders, in the same formats; without --poses "
                      "those of the map's images as well");
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->add_flag("--quiet", flags->quiet, "Do not show progress");
  command->footer(
      "An empty keyframe or frame field marks an image that is not in the map.\n"
      "Example: waystone eval lab.db queries.csv --negatives elsewhere --json");
  AddEvalTrajectory(*command, run);
  command->callback([flags, command, &run] {
    if (!command->get_subcommands().empty()) return;  // the subcommand runs instead
    run = [flags] { return RunEval(*flags); };
  });
}

}  // namespace waystone
