// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/eval_text.h"
#include "cli/map_file.h"
#include "cli/printable_output.h"
#include "cli/progress.h"
#include "cli/query_set.h"
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
  bool json = false;
  bool quiet = false;
};

std::vector<LabelledQuery> ReadQueries(const EvalFlags& flags, const MapIndex& index) {
  if (flags.queries.empty() && flags.negatives.empty()) {
    throw MapError(ErrorCode::kUsage, "no queries; specify a CSV file or --negatives DIR");
  }
  std::vector<LabelledQuery> all;
  const auto add = [&all](std::vector<LabelledQuery> more) {
    std::move(more.begin(), more.end(), std::back_inserter(all));
  };
  for (const std::string& path : flags.queries) add(ReadQuerySet(path, index));
  for (const std::string& folder : flags.negatives) add(ReadNegatives(folder));
  return all;
}

ScoredQuery Ask(const OpenMap& map, const LabelledQuery& query,
                const KeyframePositions& positions) {
  ScoredQuery scored;
  scored.truth = query.truth;
  scored.answer = Localize(*map.index, ReadBytes(query.image), query.image.string(), {});
  if (!scored.answer.planes.keyframe || !query.position_m) return scored;
  const auto found = positions.find(scored.answer.planes.keyframe->id);
  if (found != positions.end()) scored.error_m = (found->second - *query.position_m).norm();
  return scored;
}

// One after the other: the times are those of a query that has the machine to itself.
std::vector<ScoredQuery> AskAll(const OpenMap& map, const std::vector<LabelledQuery>& queries,
                                const KeyframePositions& positions, bool quiet) {
  ProgressMeter meter(RawErrors(), ProgressStyleByName("auto", quiet), ColoursWelcome());
  std::vector<ScoredQuery> scored;
  for (const LabelledQuery& query : queries) {
    scored.push_back(Ask(map, query, positions));
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
  const std::vector<LabelledQuery> queries = ReadQueries(flags, *map.index);
  const KeyframePositions positions =
      flags.poses.empty() ? KeyframePositions{} : ReadPositions(flags.poses, *map.index);
  const std::vector<ScoredQuery> scored = AskAll(map, queries, positions, flags.quiet);
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
  command->add_option("map", flags->map, "Map file");  // not for its subcommand
  command->add_option("queries", flags->queries,
                      "CSV files with columns image and keyframe or frame, optionally x, y, z");
  command
      ->add_option("--negatives", flags->negatives,
                   "Folder of images that are not in the map; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--poses", flags->poses,
                      "CSV file with keyframe positions: columns keyframe or frame, and x, y, z");
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->add_flag("--quiet", flags->quiet, "Do not show progress");
  command->footer(
      "An empty keyframe or frame field marks an image that is not in the map.\n"
      "Example: waystone eval lab.db queries.csv --negatives elsewhere --json");
  AddEvalTrajectory(*command, run);
  command->callback([flags, command, &run] {
    if (!command->get_subcommands().empty()) return;  // it was asked instead
    run = [flags] { return RunEval(*flags); };
  });
}

}  // namespace waystone
