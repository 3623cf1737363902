// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/panorama_places.h"
#include "bench/accuracy/panorama_walks.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/accuracy/world_source.h"
#include "bench/baseline/paper_odometry.h"
#include "builder/appearance/appearance_layer.h"
#include "builder/frames/frame_pipeline.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "world/rig.h"
#include "world/setting.h"

namespace waystone::bench {
namespace {

struct Built {
  MapData map;  // with the appearance layer
  AppearanceReport report;
  double total_s = 0;
};

Built Build(Source& source, const AppearanceOptions& options) {
  const Stopwatch watch;
  AppearanceLayerBuilder builder(options);
  MapData map = BuildLayer({&source}, builder);
  return {std::move(map), builder.report(), watch.wall_s()};
}

// Bytes by which a map grows through the layer.
double BytesPerNode(const MapData& built) {
  MapData map;
  map.info = {"odometry", "waystone-bench", FeatureType::kSift, "{}", ""};
  map.sequences = built.sequences;
  const int64_t without = CountFileBytes(map);
  map.appearance = built.appearance;
  const int64_t with = CountFileBytes(map);
  return static_cast<double>(with - without) / static_cast<double>(built.appearance->nodes.size());
}

double Drift(const std::vector<Pose2>& poses, const std::vector<Pose2>& truth) {
  const double turned = poses.back().theta_rad - poses.front().theta_rad;
  const double really = truth.back().theta_rad - truth.front().theta_rad;
  return WrappedAngle(turned - really) * kDegreesPerRadian;
}

// The loops whose ends are really farther apart than a room's corner from the next.
int WrongLoops(const AppearanceLayer& layer, const std::vector<Pose2>& truth, double limit_m) {
  int wrong = 0;
  for (const AppearanceEdge& edge : layer.edges) {
    if (edge.kind != AppearanceEdgeKind::kLoop) continue;
    const Pose2& a = truth[edge.a.value - 1];
    const Pose2& b = truth[edge.b.value - 1];
    wrong += std::hypot(a.x - b.x, a.y - b.y) > limit_m;
  }
  return wrong;
}

nlohmann::json Score(const std::string& name, const Built& built, const std::vector<Pose2>& truth) {
  constexpr double kWrongLoop_m = 1.5;
  const AppearanceReport& report = built.report;
  const Points2 places = PlacesOf(truth);
  const ShapeDifference alone = CompareShapes(places, PlacesOf(report.odometry));
  const ShapeDifference closed = CompareShapes(places, PlacesOf(report.poses));
  const int loops = report.loops_supported - report.loops_rejected;
  const int wrong = WrongLoops(*built.map.appearance, truth, kWrongLoop_m);
  const double bytes = BytesPerNode(built.map);
  std::printf(
      "%-10s %4d panoramas  odometry alone %.5f (turned by %+.1f deg)  with loops %.5f (%+.1f deg)"
      "  loops: %d candidates, %d certain, %d supported, %d rejected, %d kept, %d wrong"
      "  %.0f bytes a node  %.1f s\n",
      name.c_str(), report.panoramas, alone.mu, Drift(report.odometry, truth), closed.mu,
      Drift(report.poses, truth), report.loop_candidates, report.loops_certain,
      report.loops_supported, report.loops_rejected, loops, wrong, bytes, built.total_s);
  return {{"panoramas", report.panoramas},
          {"odometry", alone.mu},
          {"with_loops", closed.mu},
          {"loops", loops},
          {"loops_wrong", wrong},
          {"bytes_per_node", bytes},
          {"seconds",
           {{"decode", report.decode_s},
            {"describe", report.observe_s},
            {"odometry", report.odometry_s},
            {"loops", report.loops_s},
            {"graph", report.graph_s},
            {"total", built.total_s}}}};
}

nlohmann::json OfWalk(const std::string& name, const AppearanceOptions& options) {
  const PanoramaWalk walk = PanoramaWalkByName(name);
  const Renderer renderer(PanoramaCamera(kPanoramaWidth));
  WorldSource source(walk.world, renderer, walk.walk);
  const std::vector<Pose2> truth = GroundPoses(walk.walk);
  nlohmann::json json = Score(name, Build(source, options), truth);
  const double wheels = CompareShapes(PlacesOf(truth), PlacesOf(WheelOdometry(walk.walk))).mu;
  std::printf("%-10s the robot's own odometry (simulated wheels) %.5f\n", name.c_str(), wheels);
  json["wheels"] = wheels;
  const std::vector<Pose2> by_paper = FollowByPaper(DescribeWalk(walk), options.odometry.k1);
  json["paper"] = CompareShapes(PlacesOf(truth), PlacesOf(by_paper)).mu;
  std::printf("%-10s the paper's odometry %.5f\n", name.c_str(), json["paper"].get<double>());
  return json;
}

nlohmann::json OfPlaces(const std::string& folder, const AppearanceOptions& options) {
  std::vector<Pose2> truth;
  for (const PanoramaPlace& place : ReadPlaces(folder)) {
    truth.push_back({place.position_m.x(), place.position_m.y(), place.yaw_rad});
  }
  const std::unique_ptr<Source> source = OpenSource(folder + "/panorama", {});
  return Score("places", Build(*source, options), truth);
}

}  // namespace

int RunOdometry(const Args& raw) {
  Args args = raw;
  AppearanceOptions options;
  options.odometry.k1 = std::stoi(TakeOption(args, "k1", std::to_string(options.odometry.k1)));
  options.odometry.max_span =
      std::stoi(TakeOption(args, "span", std::to_string(options.odometry.max_span)));
  options.redundancy.max_loss = std::stod(TakeOption(args, "max-loss", "0"));
  const std::string only = TakeOption(args, "walk", "");
  if (args.size() > 1) throw MapError(ErrorCode::kUsage, "odometry takes one folder at most");
  std::printf("shape differences (0 the same shape, 1 nothing in common)\n");
  nlohmann::json json = {{"bench", "odometry"}};
  for (const std::string& name : PanoramaWalkNames()) {
    if (only.empty() || only == name) json[name] = OfWalk(name, options);
  }
  if (!args.empty()) json["places"] = OfPlaces(args[0], options);
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
