// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/accuracy/benches.h"
#include "bench/accuracy/common.h"
#include "bench/accuracy/recall_sets.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/accuracy/walk_map.h"
#include "bench/accuracy/world_source.h"
#include "builder/joining/merge_maps.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "localizer/localizer.h"
#include "localizer/planes/locate.h"
#include "schema/sessions.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kForeign = 48;

// The map's images from one to another, by their numbers in the whole set.
MapData BuildPart(const RecallSet& set, size_t first, size_t end, const std::string& name) {
  MemorySequence sequence{.name = name, .camera = {}};
  for (size_t i = first; i < end; ++i) {
    const fs::path path = set.map[i];
    sequence.frames.emplace_back(FrameInfo{static_cast<int>(i), path.filename(), {}},
                                 [path] { return DecodeGrey(ReadBytes(path)); });
  }
  return BuildWalk(std::make_unique<MemorySource>(std::move(sequence)), name).map;
}

struct Asked {
  int queries = 0;
  int same = 0;  // verdicts
  int localized_whole = 0;
  int localized_joined = 0;
  int right_whole = 0;
  int right_joined = 0;
  int ambiguous_joined = 0;
  int foreign = 0;  // of other places, look-alikes among them
  int foreign_whole = 0;
  int foreign_joined = 0;
};

void Ask(const RecallSet& set, const std::vector<RecallSet>& sets, const MapIndex& whole,
         const MapIndex& joined, Asked& asked) {
  const auto ask = [&](const fs::path& image) {
    const Features features = ExtractFeatures(DecodeGrey(ReadBytes(image)),
                                              QueryFeatureOptions(whole, PlaneQueryOptions{}));
    ++asked.queries;
    std::pair answers{LocalizeFeatures(whole, features, {}),
                      LocalizeFeatures(joined, features, {})};
    asked.same += answers.first.verdict == answers.second.verdict;
    return answers;
  };
  const auto is_localized = [](const Answer& answer) {
    return answer.verdict == Verdict::kLocalized;
  };
  const auto is_right = [&](const MapIndex& index, const Answer& answer, size_t query) {
    return is_localized(answer) &&
           set.is_right(static_cast<int>(query),
                        index.FindKeyframe(answer.planes.keyframe->id)->frame);
  };
  for (size_t q = 0; q < set.queries.size(); ++q) {
    const auto [of_whole, of_joined] = ask(set.queries[q]);
    asked.localized_whole += is_localized(of_whole);
    asked.localized_joined += is_localized(of_joined);
    asked.right_whole += is_right(whole, of_whole, q);
    asked.right_joined += is_right(joined, of_joined, q);
    asked.ambiguous_joined += of_joined.verdict == Verdict::kAmbiguous;
  }
  std::vector<fs::path> elsewhere = set.look_alikes;
  const std::vector<fs::path> foreign = ChooseForeign(sets, set, kForeign);
  elsewhere.insert(elsewhere.end(), foreign.begin(), foreign.end());
  for (const fs::path& image : elsewhere) {
    const auto [of_whole, of_joined] = ask(image);
    ++asked.foreign;
    asked.foreign_whole += is_localized(of_whole);
    asked.foreign_joined += is_localized(of_joined);
  }
}

Json JoinHalves(const RecallSet& set, const std::vector<RecallSet>& sets) {
  const size_t images = set.map.size();
  const auto share = static_cast<size_t>(kHalfShare * static_cast<double>(images));
  MapData first = BuildPart(set, 0, share, "first");
  MapData second = BuildPart(set, images - share, images, "second");
  const auto whole = MapIndex::Build(BuildPart(set, 0, images, "whole"));
  std::vector<MapData> halves;
  halves.push_back(std::move(first));
  halves.push_back(std::move(second));
  const Stopwatch watch;
  JoinResult result = MergeMaps(std::move(halves), "joined", {});
  const double seconds = watch.cpu_s();
  const auto joined = MapIndex::Build(result.map);
  Asked asked;
  Ask(set, sets, *whole, *joined, asked);
  std::printf(
      "%-16s %zu images, %d keyframes recognised, %d planes fused, %zu parts: %d of %d "
      "verdicts as the whole map's; localized %d (%d), right %d (%d), ambiguous %d, of "
      "other places %d (%d) of %d\n",
      set.name.c_str(), images, result.report.keyframes_recognised, result.report.planes_fused,
      FindParts(result.map).size(), asked.same, asked.queries, asked.localized_joined,
      asked.localized_whole, asked.right_joined, asked.right_whole, asked.ambiguous_joined,
      asked.foreign_joined, asked.foreign_whole, asked.foreign);
  return {{"set", set.name},
          {"images", images},
          {"recognised", result.report.keyframes_recognised},
          {"fused", result.report.planes_fused},
          {"parts", FindParts(result.map).size()},
          {"merge_cpu_s", seconds},
          {"queries", asked.queries},
          {"same", asked.same},
          {"same_share", static_cast<double>(asked.same) / std::max(1, asked.queries)},
          {"localized_whole", asked.localized_whole},
          {"localized_joined", asked.localized_joined},
          {"right_whole", asked.right_whole},
          {"right_joined", asked.right_joined},
          {"ambiguous_joined", asked.ambiguous_joined},
          {"own", set.queries.size()},
          {"foreign", asked.foreign},
          {"foreign_whole", asked.foreign_whole},
          {"foreign_joined", asked.foreign_joined}};
}

// Maps of places that look alike, none of which shows another: whatever is linked is wrong.
Json JoinLookAlikes(const std::vector<RecallSet>& sets) {
  std::vector<MapData> maps;
  for (const RecallSet& set : sets) {
    if (!set.look_alikes.empty()) maps.push_back(BuildPart(set, 0, set.map.size(), set.name));
  }
  if (maps.size() < 2) return nullptr;
  const size_t count = maps.size();
  const JoinResult result = MergeMaps(std::move(maps), "look-alikes", {});
  std::printf(
      "look-alikes      %zu maps, %zu keyframes: %d recognised, %d planes fused, %zu parts\n",
      count, result.map.keyframes.size(), result.report.keyframes_recognised,
      result.report.planes_fused, FindParts(result.map).size());
  return {{"maps", count},
          {"keyframes", result.map.keyframes.size()},
          {"recognised", result.report.keyframes_recognised},
          {"fused", result.report.planes_fused},
          {"parts", FindParts(result.map).size()}};
}

// A walk whose frames are rendered already.
std::unique_ptr<Source> RenderAhead(const WorldSource& walk) {
  std::vector<cv::Mat> pictures(walk.size());
  tbb::parallel_for(0, walk.size(), [&](int i) { pictures[i] = walk.Render(i).grey; });
  MemorySequence sequence{.name = "walk", .camera = walk.camera(), .frame_size = walk.frame_size()};
  for (int i = 0; i < walk.size(); ++i) {
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), {}},
                                 [picture = pictures[i]] { return picture; });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

// What a walk of `added` frames costs when it is added to a map of `frames`, beside building it
// alone.
Json CostOfAdding(int frames, int added) {
  const World world(DemoPlan(), {});
  const Renderer renderer(PinholeCamera(640, 480, 1.1));
  const auto walk_of = [&](int count, uint64_t seed) {
    WalkOptions options;
    options.step_m = 0.01;
    options.seed = seed;
    return SpreadOver(DemoWalk(world.plan(), options), count);
  };
  const Walk long_walk = walk_of(frames, 1);
  const Walk short_walk = walk_of(added, 2);
  MapData map = BuildWalk(std::make_unique<WorldSource>(world, renderer, long_walk), "map").map;
  std::unique_ptr<Source> rendered = RenderAhead(WorldSource(world, renderer, short_walk));
  const Stopwatch building;
  BuildResult walk = BuildWalk(std::move(rendered), "walk", BuiltFeatures::kKeep);
  const double build_s = building.cpu_s();
  const Stopwatch joining;
  const JoinResult result = AddToMap(std::move(map), std::move(walk.map), {}, walk.features);
  const double join_s = joining.cpu_s();
  std::printf(
      "a walk of %d frames added to %d: built in %.1f s, joined in %.1f s (CPU); %.2f times "
      "building it alone; %d keyframes recognised, %d planes fused\n",
      added, frames, build_s, join_s, (build_s + join_s) / build_s,
      result.report.keyframes_recognised, result.report.planes_fused);
  return {{"frames", frames},
          {"added", added},
          {"build_cpu_s", build_s},
          {"join_cpu_s", join_s},
          {"ratio", (build_s + join_s) / build_s},
          {"recognised", result.report.keyframes_recognised},
          {"fused", result.report.planes_fused},
          {"parts", FindParts(result.map).size()}};
}

}  // namespace

int RunJoining(const Args& given) {
  Args args = given;
  const std::string only = TakeOption(args, "only", "");
  const int frames = std::stoi(TakeOption(args, "frames", "5000"));
  if (args.size() != 1 || frames < 0 || (frames > 0 && frames < 500)) {
    throw MapError(ErrorCode::kUsage,
                   "joining takes a data folder, --only NAME and --frames of 0 or from 500 on");
  }
  const std::vector<RecallSet> sets = ReadRecallSets(args[0]);
  Json json = {{"bench", "joining"}, {"sets", Json::array()}};
  int queries = 0;
  int same = 0;
  for (const RecallSet& set : sets) {
    if (!only.empty() && set.name != only) continue;
    json["sets"].push_back(JoinHalves(set, sets));
    queries += json["sets"].back()["queries"].get<int>();
    same += json["sets"].back()["same"].get<int>();
  }
  json["queries"] = queries;
  json["same"] = same;
  json["same_share"] = static_cast<double>(same) / std::max(1, queries);
  if (only.empty()) json["look_alikes"] = JoinLookAlikes(sets);
  if (frames > 0) json["adding"] = CostOfAdding(frames, 500);
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
