// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/accuracy/benches.h"
#include "bench/accuracy/common.h"
#include "bench/accuracy/panorama_places.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/accuracy/walk_map.h"
#include "builder/joining/merge_maps.h"
#include "core/base/error.h"
#include "localizer/localizer.h"
#include "schema/sessions.h"

namespace waystone::bench {
namespace {

using Json = nlohmann::ordered_json;

MapData BuildPart(const std::vector<PanoramaPlace>& places, size_t first, size_t end,
                  const std::string& name) {
  return BuildWalk(PanoramaSource(places, first, end, name), name).map;
}

struct Counts {
  int localized = 0;
  int right = 0;
  int foreign = 0;  // localized
};

struct Joined {
  int panoramas = 0;
  int asked = 0;
  int foreign = 0;
  int same = 0;  // verdicts
  int recognised = 0;
  int loops = 0;
  int parts = 0;
  double merge_cpu_s = 0;
  double build_cpu_s = 0;  // of the whole
  Counts whole;
  Counts joined;
};

// A place is right where its nearest node is.
class PanoramaMap {
 public:
  PanoramaMap(MapData map, const std::vector<PanoramaPlace>& mapped, double right_m)
      : index_(MapIndex::Build(std::move(map))), mapped_(mapped), right_m_(right_m) {}

  Verdict Ask(const PanoramaPlace& place, Counts& counts) const {
    const Answer answer = LocalizeImage(*index_, place.grey, {});
    if (answer.verdict != Verdict::kLocalized) return answer.verdict;
    ++counts.localized;
    const auto& nodes = index_->map().appearance->nodes;
    const auto node =
        std::ranges::find(nodes, answer.panorama->node.id, [](const auto& n) { return n.id; });
    const Eigen::Vector2d& there = mapped_[node->frame].position_m;
    counts.right += (there - place.position_m).norm() <= right_m_;
    return answer.verdict;
  }
  Verdict AskForeign(const PanoramaPlace& place, Counts& counts) const {
    const Verdict verdict = LocalizeImage(*index_, place.grey, {}).verdict;
    counts.foreign += verdict == Verdict::kLocalized;
    return verdict;
  }

 private:
  std::shared_ptr<const MapIndex> index_;
  const std::vector<PanoramaPlace>& mapped_;
  double right_m_;
};

void JoinHalves(std::vector<PanoramaPlace> places, const std::vector<PanoramaPlace>& foreign,
                double right_m, Joined& all) {
  const SplitPlaces split = Split(InWalkOrder(std::move(places)));
  const size_t count = split.mapped.size();
  const auto share = static_cast<size_t>(kHalfShare * static_cast<double>(count));
  std::vector<MapData> halves;
  halves.push_back(BuildPart(split.mapped, 0, share, "first"));
  halves.push_back(BuildPart(split.mapped, count - share, count, "second"));
  const Stopwatch building;
  MapData whole_map = BuildPart(split.mapped, 0, count, "whole");
  all.build_cpu_s += building.cpu_s();
  const PanoramaMap whole(std::move(whole_map), split.mapped, right_m);
  const Stopwatch merging;
  JoinResult result = MergeMaps(std::move(halves), "joined", {});
  all.merge_cpu_s += merging.cpu_s();
  all.panoramas += static_cast<int>(count);
  all.recognised += result.report.panoramas_recognised;
  all.loops += result.report.loops;
  all.parts += static_cast<int>(FindParts(result.map).size());
  const PanoramaMap joined(std::move(result.map), split.mapped, right_m);
  for (const PanoramaPlace& place : split.asked) {
    ++all.asked;
    all.same += whole.Ask(place, all.whole) == joined.Ask(place, all.joined);
  }
  for (const PanoramaPlace& place : foreign) {
    ++all.foreign;
    all.same += whole.AskForeign(place, all.whole) == joined.AskForeign(place, all.joined);
  }
}

Json Report(const std::string& name, int maps, const Joined& all) {
  std::printf(
      "%-11s %d maps, %d panoramas: %d recognised, %d loops, %d parts; %d of %d verdicts as the "
      "whole maps'; localized %d (%d) of %d, right %d (%d), foreign %d (%d) of %d; merging %.1f s "
      "of CPU time (building %.1f s)\n",
      name.c_str(), maps, all.panoramas, all.recognised, all.loops, all.parts, all.same,
      all.asked + all.foreign, all.joined.localized, all.whole.localized, all.asked,
      all.joined.right, all.whole.right, all.joined.foreign, all.whole.foreign, all.foreign,
      all.merge_cpu_s, all.build_cpu_s);
  return {{"name", name},
          {"maps", maps},
          {"panoramas", all.panoramas},
          {"recognised", all.recognised},
          {"loops", all.loops},
          {"parts", all.parts},
          {"asked", all.asked},
          {"foreign", all.foreign},
          {"queries", all.asked + all.foreign},
          {"same", all.same},
          {"same_share", static_cast<double>(all.same) / std::max(1, all.asked + all.foreign)},
          {"localized_whole", all.whole.localized},
          {"localized_joined", all.joined.localized},
          {"right_whole", all.whole.right},
          {"right_joined", all.joined.right},
          {"foreign_whole", all.whole.foreign},
          {"foreign_joined", all.joined.foreign},
          {"build_cpu_s", all.build_cpu_s},
          {"merge_cpu_s", all.merge_cpu_s},
          {"merge_share", all.merge_cpu_s / std::max(1e-9, all.build_cpu_s)}};
}

}  // namespace

int RunJoiningPanoramas(const Args& given) {
  Args args = given;
  const int flats = std::stoi(TakeOption(args, "flats", "4"));
  const auto first = static_cast<uint64_t>(std::stoi(TakeOption(args, "first-flat", "101")));
  if (args.size() > 1 || flats < 1) {
    throw MapError(ErrorCode::kUsage,
                   "joining-panoramas takes at most one folder of panoramas, --flats N of at least "
                   "1 and --first-flat SEED");
  }
  constexpr double kFlat_m = 2;
  constexpr double kPlaces_m = 5;  // two of their steps
  Json json = {{"bench", "joining-panoramas"}, {"sets", Json::array()}};
  const std::vector<PanoramaPlace> other_flat =
      RenderFlatPlaces(first + static_cast<uint64_t>(flats));
  Joined of_flats;
  for (uint64_t seed = first; seed < first + static_cast<uint64_t>(flats); ++seed) {
    JoinHalves(RenderFlatPlaces(seed), other_flat, kFlat_m, of_flats);
  }
  json["sets"].push_back(Report("flats", flats, of_flats));
  if (!args.empty()) {
    Joined of_places;
    JoinHalves(ReadPlaces(args[0]), other_flat, kPlaces_m, of_places);
    json["sets"].push_back(Report("dealership", 1, of_places));
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
