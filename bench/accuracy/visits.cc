// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "bench/accuracy/benches.h"
#include "bench/accuracy/common.h"
#include "bench/accuracy/image_changes.h"
#include "bench/accuracy/recall_sets.h"
#include "bench/accuracy/walk_map.h"
#include "builder/joining/merge_maps.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "localizer/localizer.h"
#include "localizer/planes/locate.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kForeign = 48;

// The picture as another visit would show it: a part of it, from 90 to 97 % of its width, under the
// light of that visit, with the sensor's noise.
cv::Mat SeenAgain(const cv::Mat& grey, double light, Random& random) {
  constexpr double kNoise = 3;  // grey levels
  const double share = random.Uniform(0.90, 0.97);
  const cv::Size size(cvRound(share * grey.cols), cvRound(share * grey.rows));
  const cv::Point corner(random.Below(grey.cols - size.width + 1),
                         random.Below(grey.rows - size.height + 1));
  cv::Mat again;
  cv::resize(grey({corner, size}), again, grey.size(), 0, 0, cv::INTER_CUBIC);
  return Expose(again, light, kNoise, random);
}

// The set's images; for every visit but the first, as another visit would show them.
std::unique_ptr<Source> OpenVisit(const RecallSet& set, int visit) {
  MemorySequence sequence{.name = "visit " + std::to_string(visit), .camera = {}};
  const double light = Random(visit).Uniform(0.7, 1.2);
  for (size_t i = 0; i < set.map.size(); ++i) {
    const fs::path path = set.map[i];
    sequence.frames.emplace_back(FrameInfo{static_cast<int>(i), path.filename(), {}}, [=] {
      const cv::Mat grey = DecodeGrey(ReadBytes(path));
      Random random(1000 * visit + i);
      return visit == 1 ? grey : SeenAgain(grey, light, random);
    });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

struct Queries {
  std::vector<Features> own;
  std::vector<Features> foreign;
};

Json Ask(const RecallSet& set, const Queries& queries, const MapData& map, int visits) {
  const auto index = MapIndex::Build(map);
  int localized = 0;
  int right = 0;
  int ambiguous = 0;
  std::vector<double> ms;
  for (size_t q = 0; q < queries.own.size(); ++q) {  // one at a time, to measure their times
    const Answer answer = LocalizeFeatures(*index, queries.own[q], {});
    ms.push_back(answer.timing.total_ms);
    ambiguous += answer.verdict == Verdict::kAmbiguous;
    if (answer.verdict != Verdict::kLocalized) continue;
    ++localized;
    const int frame = index->FindKeyframe(answer.planes.keyframe->id)->frame;
    right += set.is_right(static_cast<int>(q), frame);
  }
  std::atomic<int> foreign = 0;
  tbb::parallel_for(size_t{0}, queries.foreign.size(), [&](size_t q) {
    foreign += LocalizeFeatures(*index, queries.foreign[q], {}).verdict == Verdict::kLocalized;
  });
  std::printf(
      "%-16s %d visits: %zu keyframes, %zu planes, %zu links; localized %d, right %d, ambiguous "
      "%d of %zu; of other places %d of %zu\n",
      set.name.c_str(), visits, map.keyframes.size(), map.planes.size(), map.links.size(),
      localized, right, ambiguous, queries.own.size(), foreign.load(), queries.foreign.size());
  (void)std::fflush(stdout);
  return {{"visits", visits},
          {"keyframes", map.keyframes.size()},
          {"planes", map.planes.size()},
          {"links", map.links.size()},
          {"asked", queries.own.size()},
          {"localized", localized},
          {"right", right},
          {"ambiguous", ambiguous},
          {"foreign", queries.foreign.size()},
          {"foreign_localized", foreign.load()},
          {"median_query_ms", Quantile(ms, 0.5)}};
}

// The map of the first visit, to which the others are added one by one.
Json AddVisits(const RecallSet& set, const Queries& queries, MapData map, int visits) {
  Json rows = Json::array();
  rows.push_back(Ask(set, queries, map, 1));
  for (int visit = 2; visit <= visits; ++visit) {
    BuildResult walk =
        BuildWalk(OpenVisit(set, visit), "visit " + std::to_string(visit), BuiltFeatures::kKeep);
    map = AddToMap(std::move(map), std::move(walk.map), {}, walk.features).map;
    map.info.version = "sha256:" + std::to_string(visit) + " visits";
    rows.push_back(Ask(set, queries, map, visit));
  }
  return rows;
}

// The same visits, built into one map.
Json BuildVisits(const RecallSet& set, const Queries& queries, int visits) {
  std::vector<std::unique_ptr<Source>> sources;
  for (int visit = 1; visit <= visits; ++visit) sources.push_back(OpenVisit(set, visit));
  return Ask(set, queries, BuildMap(sources, {}, {}).map, visits);
}

}  // namespace

int RunVisits(const Args& given) {
  Args args = given;
  const int visits = std::stoi(TakeOption(args, "visits", "9"));
  if (args.size() != 1 || visits < 1) {
    throw MapError(ErrorCode::kUsage, "visits takes a data folder, and --visits of 1 or more");
  }
  const std::vector<RecallSet> sets = ReadRecallSets(args[0]);
  Json json{{"bench", "visits"}, {"sets", Json::array()}};
  for (const RecallSet& set : sets) {
    if (set.name != "corridor" && set.name != "church" && set.name != "pavilion-midday") continue;
    MapData first = BuildWalk(OpenVisit(set, 1), "visit 1").map;
    const FeatureOptions features = QueryFeatureOptions(*MapIndex::Build(first), {});
    const Queries queries{ExtractAll(set.queries, features),
                          ExtractAll(ChooseForeign(sets, set, kForeign), features)};
    Json added = AddVisits(set, queries, std::move(first), visits);
    json["sets"].push_back({{"name", set.name},
                            {"added", std::move(added)},
                            {"built", BuildVisits(set, queries, visits)}});
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
