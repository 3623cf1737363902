// SPDX-License-Identifier: Apache-2.0
#include "cli/demo_world.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "world/render.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

// Of another building than the demo's own.
constexpr uint64_t kOtherSeed = 77;
// Where in the walk the photos are taken, as a share of its frames.
constexpr double kPhotoAt = 0.4;
constexpr uint64_t kPhotoNoiseSeed = 4242;

// Pictures of the walk: a demo should be over soon.
constexpr size_t kPictures = 160;

// The first part of a tour, in steps as of a video of which every third frame is taken.
Walk ShortWalk(const FloorPlan& plan) {
  WalkOptions options;
  options.step_m = 0.15;
  options.turn_rad = 0.12;
  options.frame_rate = 5.0;
  Walk walk = DemoWalk(plan, options);
  walk.frames.resize(std::min(walk.frames.size(), kPictures));
  return walk;
}

// Plainer walls than a made world has by itself: more like an office, and quicker to look at.
World DemoWorld() {
  WorldOptions options;
  options.texture_richness = 0.5;
  return World(DemoPlan(), options);
}

// What a phone's camera makes of it.
RenderOptions PhoneLook() {
  RenderOptions render;
  render.lens_blur_px = 0.6;
  render.noise_sigma = 3.0;
  return render;
}

World OtherWorld() {
  WorldOptions options;
  options.seed = kOtherSeed;
  options.texture_richness = 0.5;
  return World(OtherPlan(), options);
}

// Half way between two frames, so that no picture of the walk was taken there.
Eigen::Isometry3d PoseBetween(const WalkFrame& a, const WalkFrame& b) {
  const Eigen::Quaterniond qa(a.world_from_camera.rotation());
  const Eigen::Quaterniond qb(b.world_from_camera.rotation());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = qa.slerp(0.5, qb).toRotationMatrix();
  pose.translation() = (a.world_from_camera.translation() + b.world_from_camera.translation()) / 2;
  return pose;
}

std::vector<uint8_t> Photo(const World& world, const Walk& walk) {
  const auto at = static_cast<size_t>(kPhotoAt * static_cast<double>(walk.frames.size()));
  RenderOptions look = PhoneLook();
  look.noise_seed = kPhotoNoiseSeed;
  const RenderedFrame frame = Render(world, WriteWalkOptions().camera,
                                     PoseBetween(walk.frames.at(at), walk.frames.at(at + 1)), look);
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", frame.grey, jpeg);
  return jpeg;
}

std::filesystem::path Save(const std::filesystem::path& path, const std::vector<uint8_t>& bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) {
    throw MapError(ErrorCode::kFileUnwritable,
                   path.string() + " can't be written; see whether its folder is full");
  }
  return path;
}

}  // namespace

void WriteDemoWalk(const std::filesystem::path& dir, const WriteProgress& progress) {
  WriteWalkOptions options;
  options.render = PhoneLook();
  WriteWalk(DemoWorld(), ShortWalk(DemoPlan()), dir, options, progress);
}

DemoPhotos WriteDemoPhotos(const std::filesystem::path& dir) {
  const std::vector<uint8_t> right = Photo(DemoWorld(), ShortWalk(DemoPlan()));
  const std::vector<uint8_t> elsewhere = Photo(OtherWorld(), ShortWalk(OtherPlan()));
  std::vector<uint8_t> broken = right;
  broken.resize(broken.size() / 3);
  return {Save(dir / "right.jpg", right), Save(dir / "elsewhere.jpg", elsewhere),
          Save(dir / "broken.jpg", broken)};
}

}  // namespace waystone
