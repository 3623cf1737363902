// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/panorama_walks.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "bench/accuracy/world_source.h"
#include "core/base/random.h"
#include "world/rig.h"
#include "world/setting.h"

namespace waystone::bench {
namespace {

constexpr size_t kTourFrames = 400;
constexpr uint64_t kTourSeed = 31;
constexpr int kLongestStep = 3;  // of 10 cm
constexpr double kSwing_rad = 0.6;

World OtherWorld() {
  WorldOptions look;
  look.seed = kTourSeed;
  look.texture_richness = 0.5;
  return World(OtherPlan(), look);
}

WalkOptions TourOptions() {
  WalkOptions options;
  options.height_m = 0.9;
  options.step_m = 0.1;
  options.turn_rad = 1.0;
  options.gaze_rad = 0;
  options.sway = 0;
  options.seed = kTourSeed;
  return options;
}

PanoramaWalk Tour() {
  Walk walk = DemoWalk(OtherPlan(), TourOptions());
  walk.frames.resize(std::min(walk.frames.size(), kTourFrames));
  return {"tour", OtherWorld(), walk};
}

PanoramaWalk Uneven() {
  WalkOptions options = TourOptions();
  options.height_m = 1.5;
  options.gaze_rad = kSwing_rad;
  options.sway = 1;
  const Walk all = DemoWalk(OtherPlan(), options);
  Random random(kTourSeed);
  Walk walk;
  for (size_t i = 0; i < all.frames.size() && walk.frames.size() < kTourFrames / 2;
       i += 1 + random.Next() % kLongestStep) {
    walk.frames.push_back(all.frames[i]);
  }
  return {"uneven", OtherWorld(), walk};
}

}  // namespace

PanoramaWalk PanoramaWalkByName(const std::string& name) {
  if (name == "tour") return Tour();
  if (name == "uneven") return Uneven();
  const Setting setting = SettingByName(name);
  return {name, World(setting.plan, setting.look), setting.walk};
}

std::vector<std::string> PanoramaWalkNames() { return {"office", "laboratory", "tour", "uneven"}; }

std::vector<FourierSignature> DescribeWalk(const PanoramaWalk& walk) {
  const Renderer renderer(PanoramaCamera(kPanoramaWidth));
  const WorldSource source(walk.world, renderer, walk.walk);
  std::vector<FourierSignature> signatures(walk.walk.frames.size());
  tbb::parallel_for(size_t{0}, signatures.size(), [&](size_t i) {
    signatures[i] = Signature(source.Render(static_cast<int>(i)).grey);
  });
  return signatures;
}

Points2 PlacesOf(const std::vector<Pose2>& poses) {
  Points2 places;
  for (const Pose2& pose : poses) places.emplace_back(pose.x, pose.y);
  return places;
}

}  // namespace waystone::bench
