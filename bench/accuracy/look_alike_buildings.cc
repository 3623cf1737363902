// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/look_alike_buildings.h"

#include "bench/accuracy/relight.h"
#include "bench/accuracy/world_source.h"
#include "core/base/random.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

using Eigen::Vector3d;

constexpr int kQueries = 30;

// A step aside and a look elsewhere, where there is room for it.
Eigen::Isometry3d StepAside(const World& world, const Eigen::Isometry3d& world_from_camera,
                            Random& random) {
  Eigen::Isometry3d aside = world_from_camera;
  aside.linear() = Eigen::AngleAxisd(random.Uniform(-0.6, 0.6), Vector3d::UnitZ()) * aside.linear();
  aside.translation() += Vector3d(random.Uniform(-0.8, 0.8), random.Uniform(-0.8, 0.8), 0);
  return world.IsInside(aside.translation()) ? aside : world_from_camera;
}

}  // namespace

WorldOptions DrawBuilding(int building) {
  const auto seed = static_cast<uint64_t>(building);
  Random random(seed * 7919 + 11);
  WorldOptions options;
  options.seed = seed;
  options.texel_m = 0.006;
  options.trim = random.Uniform() < 0.7;
  options.texture_richness = random.Uniform(0.03, 0.5);
  options.bare_walls = random.Uniform(0.0, 0.8);
  options.poster_probability = random.Uniform(0.3, 0.9);
  options.repeat_poster = random.Uniform(0, 0.2);
  options.poster_width_m = random.Uniform(0.25, 0.8);
  options.poster_height_m = random.Uniform(0.3, 1.2);
  options.alike_share = random.Uniform(0.3, 0.9);
  return options;
}

FloorPlan PlanOf(int building) { return building % 2 == 0 ? DemoPlan() : OtherPlan(); }

World StoreyOf(int building, int storey) {
  WorldOptions options = DrawBuilding(building);
  options.storey = storey;
  return World(PlanOf(building), options);
}

Camera LookAlikeCamera(int width) { return PinholeCamera(width, 3 * width / 4, 1.1); }

Walk MapTour(const World& world, int visit) {
  WalkOptions options;
  options.gaze_rad = 0.4;
  options.seed = static_cast<uint64_t>(visit);
  return SpreadOver(DemoWalk(world.plan(), options), kTourFrames);
}

Walk QueryTour(const World& world, int seed) {
  const auto number = static_cast<uint64_t>(seed);
  Random random(number * 31 + 7);
  WalkOptions options;
  options.height_m = random.Uniform(1.35, 1.65);
  options.gaze_rad = random.Uniform(0.2, 0.8);
  options.gaze_period_m = random.Uniform(4, 9);
  options.seed = number + 100;
  Walk tour = SpreadOver(DemoWalk(world.plan(), options), kQueries);
  for (WalkFrame& frame : tour.frames) {
    frame.world_from_camera = StepAside(world, frame.world_from_camera, random);
  }
  return tour;
}

cv::Mat Photograph(const Renderer& renderer, const World& world,
                   const Eigen::Isometry3d& world_from_camera, uint64_t seed) {
  Random random(seed);
  RenderOptions options;
  options.lens_blur_px = random.Uniform(0.5, 1.6);
  options.noise_sigma = random.Uniform(2, 8);
  options.noise_seed = seed;
  options.exposure_gain = random.Uniform(0.4, 1.2);
  const RenderedFrame frame = renderer.Render(world, world_from_camera, options);
  return random.Uniform() < 0.5 ? frame.grey : Relight(frame, random);
}

}  // namespace waystone::bench
