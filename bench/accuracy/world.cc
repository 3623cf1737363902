// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <set>

#include "bench/accuracy/common.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/world_revisits.h"
#include "bench/accuracy/world_truth.h"
#include "builder/planes/outline.h"
#include "builder/planes/plane_features.h"
#include "core/base/error.h"
#include "schema/layers/planes/index_features.h"
#include "schema/layers/planes/surfaces.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

constexpr int kCarried = 40;          // matched features that make a plane count
constexpr double kTrueShare = 0.9;    // of a plane's features on one true plane; less is false
constexpr double kWrongView_px = 10;  // a view off by more was fused wrongly

// Planes of the map that show a true plane in a keyframe.
using Views = std::set<std::pair<int64_t, int>>;  // keyframe id, true plane

struct Figures {
  int carried = 0;  // true planes in pairs of consecutive keyframes with enough matches
  int found = 0;    // of them, are in the map in both keyframes
  int false_planes = 0;
  int wrong_views = 0;
  int surfaces = 0;
  int mixed_surfaces = 0;  // with parts of different true planes
  int wrong_edges = 0;
  int true_planes = 0;  // that the map's planes show
  RevisitFigures revisits;
  std::vector<double> view_errors_px;
  // Of the planes that show one true plane: pixels inside their outlines and inside the convex
  // hulls of their features, and those of them that show that true plane.
  WorldTruth::Outlined outlines;
  WorldTruth::Outlined hulls;
};

void Add(const WorldTruth::Outlined& one, WorldTruth::Outlined& sum) {
  sum.pixels += one.pixels;
  sum.of_plane += one.of_plane;
}

double ShareOfPlane(const WorldTruth::Outlined& pixels) {
  return static_cast<double>(pixels.of_plane) / std::max(1, pixels.pixels);
}

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

SharedPlanes FindSharedPlanes(const WorldTruth& truth, int keyframes) {
  SharedPlanes shared(keyframes);
  tbb::parallel_for(1, keyframes, [&](int b) {
    shared[b].resize(b);
    for (int a = 0; a < b; ++a) {
      for (const auto& [plane, matches] : truth.CarriedMatches(a, b)) {
        if (matches >= kCarried) shared[b][a].insert(plane);
      }
    }
  });
  return shared;
}

void CountSurfaces(const MapData& map, const std::map<PlaneId, int>& owners, Figures& figures) {
  const std::vector<PlaneId> surfaces = FindSurfaces(map.planes, map.edges);
  figures.surfaces = waystone::CountSurfaces(surfaces);
  std::map<PlaneId, std::set<int>> shown;
  std::set<int> all;
  for (size_t p = 0; p < surfaces.size(); ++p) {
    const auto owner = owners.find(map.planes[p].id);
    if (owner == owners.end()) continue;  // a false plane
    shown[surfaces[p]].insert(owner->second);
    all.insert(owner->second);
  }
  for (const auto& [surface, planes] : shown) {
    if (planes.size() == 1) continue;
    ++figures.mixed_surfaces;
    std::printf("mixed: the surface of plane %lld shows %zu true planes\n",
                static_cast<long long>(surface.value), planes.size());
  }
  figures.true_planes = static_cast<int>(all.size());
}

// Edges between two planes, one of which shows a true plane that the edge's keyframes don't show.
void CountWrongEdges(const WorldTruth& truth, const MapData& map,
                     const std::map<PlaneId, int>& owners, Figures& figures) {
  for (const Edge& edge : map.edges) {
    for (const PlaneId plane : {edge.a, edge.b}) {
      const auto owner = owners.find(plane);
      if (owner == owners.end()) continue;  // a false plane
      if (truth.Shows(edge.from, owner->second) && truth.Shows(edge.to, owner->second)) continue;
      ++figures.wrong_edges;
      std::printf(
          "wrong: edge %lld-%lld, of keyframes %lld and %lld, which don't show plane %lld\n",
          static_cast<long long>(edge.a.value), static_cast<long long>(edge.b.value),
          static_cast<long long>(edge.from.value), static_cast<long long>(edge.to.value),
          static_cast<long long>(plane.value));
      break;
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
    Add(truth.PixelsInside(plane.outline, plane.reference, owner.plane), figures.outlines);
    Add(truth.PixelsInside(ConvexHull(PositionsOf(plane)), plane.reference, owner.plane),
        figures.hulls);
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
  CountSurfaces(map, owners, figures);
  CountWrongEdges(truth, map, owners, figures);
  figures.revisits =
      CountRevisits(FindSharedPlanes(truth, static_cast<int>(map.keyframes.size())), map, owners);
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
  const BuildOptions options = TakeBuildSettings(args);
  if (!args.empty() || (plan != "demo" && plan != "other")) {
    throw MapError(ErrorCode::kUsage,
                   "world takes --frames, --seed, --plan demo|other, "
                   "--repeat-poster, --bare-walls and --set NAME=VALUE");
  }
  const World world(plan == "demo" ? DemoPlan() : OtherPlan(), world_options);
  WalkOptions walk_options;
  walk_options.step_m = 0.1;
  Walk walk = DemoWalk(world.plan(), walk_options);
  if (static_cast<int>(walk.frames.size()) > frames) walk.frames.resize(frames);
  const Renderer renderer(PinholeCamera(640, 480, 1.2));
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<WorldSource>(world, renderer, walk));
  const BuildResult built = BuildMap(sources, options, {});
  const MapData& map = built.map;
  const WorldTruth truth(world, static_cast<const WorldSource&>(*sources.front()), walk, map,
                         options.features);
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
      {"surfaces", figures.surfaces},
      {"mixed_surfaces", figures.mixed_surfaces},
      {"true_planes", figures.true_planes},
      {"edges", map.edges.size()},
      {"wrong_edges", figures.wrong_edges},
      {"features", CountFeatures(map)},
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
      {"outlines",
       {{"of_plane_share", ShareOfPlane(figures.outlines)},
        {"hulls_of_plane_share", ShareOfPlane(figures.hulls)},
        {"kept_of_hulls",
         static_cast<double>(figures.outlines.of_plane) / std::max(1, figures.hulls.of_plane)}}},
      {"revisits",
       {{"pairs_of_visits", figures.revisits.pairs},
        {"too_few_matches", figures.revisits.too_few_matches},
        {"seen_again", figures.revisits.seen_again},
        {"one_plane", figures.revisits.one_plane},
        {"one_surface", figures.revisits.one_surface},
        {"joined_by_edge", figures.revisits.joined_by_edge},
        {"joined", figures.revisits.one_plane + figures.revisits.one_surface +
                       figures.revisits.joined_by_edge},
        {"no_plane", figures.revisits.no_plane},
        {"apart", figures.revisits.apart}}},
      {"build_s", built.report.total_s}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
