// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <set>

#include "bench/accuracy/common.h"
#include "bench/accuracy/world_truth.h"
#include "core/base/error.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

constexpr int kCarried = 40;          // matched features that make a plane count
constexpr double kTrueShare = 0.9;    // of a plane's features on one true plane; less is false
constexpr double kWrongView_px = 10;  // a view off by more was fused wrongly
constexpr double kRevisited = 0.6;    // share of a plane that the other one's reference shows

// Planes of the map that show a true plane in a keyframe.
using Views = std::set<std::pair<int64_t, int>>;  // keyframe id, true plane

struct Figures {
  int carried = 0;  // true planes in pairs of consecutive keyframes with enough matches
  int found = 0;    // of them, are in the map in both keyframes
  int false_planes = 0;
  int wrong_views = 0;
  int revisits = 0;         // pairs of planes, or of views of one plane, that show a surface again
  int revisits_joined = 0;  // of them, fused or joined by an edge
  std::vector<double> view_errors_px;
};

void CountFound(const WorldTruth& truth, const MapData& map, const Views& views, Figures& figures) {
  for (int k = 1; k < static_cast<int>(map.keyframes.size()); ++k) {
    if (map.keyframes[k].stretch != map.keyframes[k - 1].stretch) continue;
    for (const auto& [plane, matches] : truth.CarriedMatches(k - 1, k)) {
      if (matches < kCarried) continue;
      ++figures.carried;
      const bool found = views.contains({map.keyframes[k - 1].id.value, plane}) &&
                         views.contains({map.keyframes[k].id.value, plane});
      figures.found += found;
    }
  }
}

// Fused: views of one plane with keyframes between them that didn't see it. Not fused: two planes
// of one surface, one of which the other one's reference image shows, seen at different times.
void CountRevisits(const WorldTruth& truth, const MapData& map,
                   const std::map<PlaneId, int>& owners, Figures& figures) {
  std::set<std::pair<PlaneId, PlaneId>> joined;
  for (const Edge& edge : map.edges) joined.insert({edge.a, edge.b});
  for (const Plane& plane : map.planes) {
    for (size_t v = 1; v < plane.views.size(); ++v) {
      const bool again = plane.views[v].keyframe.value > plane.views[v - 1].keyframe.value + 1;
      figures.revisits += again;
      figures.revisits_joined += again;
    }
  }
  for (const Plane& m : map.planes) {
    for (const Plane& n : map.planes) {
      if (!(m.id < n.id) || !owners.contains(m.id) || !owners.contains(n.id) ||
          owners.at(m.id) != owners.at(n.id)) {
        continue;
      }
      const int plane = owners.at(m.id);
      if (std::min(truth.SharedView(m, n, plane), truth.SharedView(n, m, plane)) < kRevisited) {
        continue;
      }
      ++figures.revisits;
      const bool is_joined = joined.contains({m.id, n.id});
      figures.revisits_joined += is_joined;
      if (!is_joined) {
        std::printf("not fused: planes %lld and %lld of true plane %d (%zu and %zu features)\n",
                    static_cast<long long>(m.id.value), static_cast<long long>(n.id.value), plane,
                    m.features.size(), n.features.size());
      }
    }
  }
}

Figures Measure(const WorldTruth& truth, const MapData& map) {
  Figures figures;
  Views views;
  std::map<PlaneId, int> owners;
  for (const Plane& plane : map.planes) {
    const WorldTruth::Owner owner = truth.OwnerOf(plane);
    if (owner.share < kTrueShare) {
      ++figures.false_planes;
      std::printf("false: plane %lld, %zu features, %.0f %% of them on true plane %d\n",
                  static_cast<long long>(plane.id.value), plane.features.size(), 100 * owner.share,
                  owner.plane);
      continue;
    }
    owners[plane.id] = owner.plane;
    for (const PlaneView& view : plane.views) {
      views.insert({view.keyframe.value, owner.plane});
      if (view.keyframe == plane.reference) continue;
      const std::vector<double> errors = truth.ViewErrors(plane, view, owner.plane);
      if (errors.empty()) continue;
      figures.view_errors_px.push_back(Quantile(errors, 0.5));
      if (figures.view_errors_px.back() > kWrongView_px) {
        ++figures.wrong_views;
        std::printf("wrong: plane %lld in keyframe %lld is off by %.1f px\n",
                    static_cast<long long>(plane.id.value),
                    static_cast<long long>(view.keyframe.value), figures.view_errors_px.back());
      }
    }
  }
  CountFound(truth, map, views, figures);
  CountRevisits(truth, map, owners, figures);
  return figures;
}

}  // namespace

int RunWorld(const Args& raw) {
  Args args = raw;
  const int frames = std::stoi(TakeOption(args, "frames", "1000"));
  WorldOptions world_options;
  world_options.seed = std::stoull(TakeOption(args, "seed", "1"));
  world_options.repeat_poster = std::stod(TakeOption(args, "repeat-poster", "0"));
  world_options.bare_walls = std::stod(TakeOption(args, "bare-walls", "0"));
  const std::string plan = TakeOption(args, "plan", "demo");
  if (!args.empty() || (plan != "demo" && plan != "other")) {
    throw MapError(ErrorCode::kUsage,
                   "world takes --frames, --seed, --plan demo|other, "
                   "--repeat-poster and --bare-walls");
  }
  const World world(plan == "demo" ? DemoPlan() : OtherPlan(), world_options);
  WalkOptions walk_options;
  walk_options.step_m = 0.1;
  Walk walk = DemoWalk(world.plan(), walk_options);
  if (static_cast<int>(walk.frames.size()) > frames) walk.frames.resize(frames);
  const Renderer renderer(PinholeCamera(640, 480, 1.2));
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<WorldSource>(world, renderer, walk));
  const BuildResult built = BuildMap(sources, BuildOptions{}, {});
  const MapData& map = built.map;
  const WorldTruth truth(world, static_cast<const WorldSource&>(*sources.front()), walk, map);
  const Figures figures = Measure(truth, map);
  const PlaneReport& report = built.report.planes.value();
  const nlohmann::ordered_json json = {
      {"bench", "world"},
      {"plan", plan},
      {"frames", report.frames},
      {"keyframes", map.keyframes.size()},
      {"stretches", report.stretches},
      {"rotation_only", report.rotation_only},
      {"planes", map.planes.size()},
      {"edges", map.edges.size()},
      {"features", FeatureCount(map)},
      {"fused", report.planes_fused},
      {"rejected", report.planes_rejected},
      {"carried", figures.carried},
      {"found", figures.found},
      {"found_share", static_cast<double>(figures.found) / std::max(1, figures.carried)},
      {"false_planes", figures.false_planes},
      {"false_share",
       static_cast<double>(figures.false_planes) / std::max<size_t>(1, map.planes.size())},
      {"median_view_error_px", Quantile(figures.view_errors_px, 0.5)},
      {"p90_view_error_px", Quantile(figures.view_errors_px, 0.9)},
      {"wrong_views", figures.wrong_views},
      {"revisits", figures.revisits},
      {"revisits_joined", figures.revisits_joined},
      {"build_s", built.report.total_s}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
