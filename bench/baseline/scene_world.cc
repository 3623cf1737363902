// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "bench/accuracy/world_source.h"
#include "bench/baseline/scenes.h"
#include "core/homography/homography.h"
#include "world/rig.h"
#include "world/truth.h"

namespace waystone::bench {
namespace {

Walk MapWalk(const World& world, int frames) {
  WalkOptions options;
  options.step_m = 0.1;
  Walk walk = DemoWalk(world.plan(), options);
  if (static_cast<int>(walk.frames.size()) > frames) walk.frames.resize(frames);
  return walk;
}

// `count` frames spread over the part of the plan that `share` of the tour covers.
Walk QueryWalk(const World& world, int count, double share) {
  WalkOptions options;
  options.step_m = 0.1;
  options.height_m = 1.6;
  options.gaze_rad = 0.5;
  options.gaze_period_m = 5.0;
  options.seed = 7;
  const Walk all = DemoWalk(world.plan(), options);
  Walk walk;
  const double last = share * (static_cast<double>(all.frames.size()) - 1);
  for (int i = 0; i < count; ++i) {
    walk.frames.push_back(all.frames[static_cast<size_t>(last * (i + 0.5) / count)]);
  }
  return walk;
}

class WorldScene : public Scene {
 public:
  WorldScene(int map_frames, int queries, const SceneLimits& limits)
      : limits_(limits),
        walk_(MapWalk(world_, map_frames)),
        query_walk_(QueryWalk(world_, queries,
                              static_cast<double>(walk_.frames.size()) /
                                  static_cast<double>(MapWalk(world_, 1 << 20).frames.size()))),
        query_source_(world_, renderer_, query_walk_) {
    for (int q = 0; q < queries; ++q) frames_.push_back(query_source_.Render(q));
  }

  const std::string& name() const override { return name_; }
  std::unique_ptr<Source> OpenMap() const override {
    return std::make_unique<WorldSource>(world_, renderer_, walk_);
  }
  int queries() const override { return static_cast<int>(frames_.size()); }
  cv::Mat Decode(int query) const override { return frames_[query].grey; }
  bool IsRight(int query, const SceneAnswer& answer) const override {
    const std::optional<double> error = WorldError(
        world_, renderer_.camera(), frames_[query], query_walk_.frames[query].world_from_camera,
        walk_.frames[answer.reference_frame].world_from_camera, answer);
    return error && *error <= limits_.world_px;
  }
  std::string Criterion() const override {
    return "median transfer error by the rendered planes <= " +
           std::to_string(static_cast<int>(limits_.world_px)) + " px";
  }

 private:
  std::string name_ = "world";
  SceneLimits limits_;
  World world_{DemoPlan()};
  Renderer renderer_{PinholeCamera(640, 480, 1.2)};
  Walk walk_;
  Walk query_walk_;
  WorldSource query_source_;
  std::vector<RenderedFrame> frames_;
};

}  // namespace

std::optional<double> WorldError(const World& world, const Camera& camera,
                                 const RenderedFrame& query,
                                 const Eigen::Isometry3d& world_from_query,
                                 const Eigen::Isometry3d& world_from_reference,
                                 const SceneAnswer& answer) {
  std::vector<double> errors;
  for (size_t i = 0; i < answer.query_points.size(); ++i) {
    const Eigen::Vector2d& x = answer.query_points[i];
    const int plane = query.plane_ids.at<uint16_t>(static_cast<int>(std::lround(x.y())),
                                                   static_cast<int>(std::lround(x.x())));
    if (plane == 0) continue;
    const Eigen::Matrix3d truth =
        PlaneHomography(world.PlaneById(plane), camera, world_from_query, world_from_reference);
    const Eigen::Vector2d at =
        InImage(answer.reference_points[i], answer.reference_width, camera.width);
    errors.push_back((at - Apply(truth, x)).norm());
  }
  if (errors.size() < kMinJudged) return std::nullopt;
  return Quantile(std::move(errors), 0.5);
}

std::unique_ptr<Scene> MakeWorldScene(int map_frames, int queries, const SceneLimits& limits) {
  return std::make_unique<WorldScene>(map_frames, queries, limits);
}

}  // namespace waystone::bench
