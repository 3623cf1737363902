// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/demo_world.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/image/encode.h"
#include "world/draw_plan.h"
#include "world/render.h"
#include "world/setting.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

// The seed of another building than the demo's own.
constexpr uint64_t kOtherSeed = 77;
// Where in the walk the photos are taken, as a share of its frames.
constexpr double kPhotoAt = 0.4;
constexpr uint64_t kPhotoNoiseSeed = 4242;

// Photos of the walk's building, and as many of another one, that come with a written walk.
constexpr size_t kQueries = 20;

// Of the drawing of the building: 40 px per metre.
constexpr int kPlanCellPx = 20;

// The number of pictures of the walk: a demo should be over soon.
constexpr size_t kPictures = 160;

// The first part of a tour, in the steps of a video of which every third frame is used.
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

// Halfway between two frames, so that no picture of the walk was taken there.
Eigen::Isometry3d PoseBetween(const WalkFrame& a, const WalkFrame& b) {
  const Eigen::Quaterniond qa(a.world_from_camera.rotation());
  const Eigen::Quaterniond qb(b.world_from_camera.rotation());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = qa.slerp(0.5, qb).toRotationMatrix();
  pose.translation() = (a.world_from_camera.translation() + b.world_from_camera.translation()) / 2;
  return pose;
}

// A photo from between a frame of the walk and the next one.
std::vector<uint8_t> PhotoAfter(const World& world, const Walk& walk, size_t at) {
  RenderOptions look = PhoneLook();
  look.noise_seed = kPhotoNoiseSeed + at;
  const RenderedFrame frame = Render(world, WriteWalkOptions().camera,
                                     PoseBetween(walk.frames.at(at), walk.frames.at(at + 1)), look);
  return EncodeJpeg(frame.grey);
}

std::vector<uint8_t> RenderPhoto(const World& world, const Walk& walk) {
  return PhotoAfter(world, walk,
                    static_cast<size_t>(kPhotoAt * static_cast<double>(walk.frames.size())));
}

std::filesystem::path Save(const std::filesystem::path& path, const std::vector<uint8_t>& bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) {
    throw MapError(ErrorCode::kFileUnwritable,
                   path.string() + " can't be written; check the free space");
  }
  return path;
}

std::string Row(const std::string& image, size_t frame, const Eigen::Vector3d& position) {
  std::ostringstream row;
  row << image << ',' << frame << ',' << position.x() << ',' << position.y() << ',' << position.z()
      << '\n';
  return row.str();
}

}  // namespace

void WriteDemoWalk(const std::filesystem::path& dir, const WriteProgress& progress) {
  WriteWalkOptions options;
  options.render = PhoneLook();
  WriteWalk(DemoWorld(), ShortWalk(DemoPlan()), dir, options, progress);
  std::vector<uint8_t> drawing;
  cv::imencode(".png", DrawPlan(DemoPlan(), kPlanCellPx), drawing);
  Save(dir / "plan.png", drawing);
}

void WriteSetting(const std::string& name, const std::filesystem::path& dir,
                  const WriteProgress& progress) {
  const Setting setting = SettingByName(name);
  WriteWalkOptions options;
  options.pinhole = false;
  options.panorama = true;
  options.render = PhoneLook();
  WriteWalk(World(setting.plan, setting.look), setting.walk, dir, options, progress);
  std::ostringstream rows;
  rows << std::setprecision(12) << "frame,time_s,x,y,theta_rad\n";
  const std::vector<Pose2> odometry = WheelOdometry(setting.walk);
  for (size_t i = 0; i < odometry.size(); ++i) {
    rows << i << ',' << setting.walk.frames[i].time_s << ',' << odometry[i].x << ','
         << odometry[i].y << ',' << odometry[i].theta_rad << '\n';
  }
  const std::string text = rows.str();
  Save(dir / "odometry.csv", {text.begin(), text.end()});
}

void WriteDemoQueries(const std::filesystem::path& dir) {
  const World world = DemoWorld();
  const Walk walk = ShortWalk(DemoPlan());
  const World other = OtherWorld();
  const Walk elsewhere = ShortWalk(OtherPlan());
  std::error_code seen_by_save;
  std::filesystem::create_directory(dir / "queries", seen_by_save);
  std::string rows = "image,frame,x,y,z\n";
  const size_t step = walk.frames.size() / kQueries;
  for (size_t at = step / 2; at + 1 < walk.frames.size(); at += step) {
    const std::string name = std::to_string(at) + ".jpg";
    Save(dir / "queries" / name, PhotoAfter(world, walk, at));
    rows +=
        Row("queries/" + name, at, PoseBetween(walk.frames[at], walk.frames[at + 1]).translation());
    Save(dir / "queries" / ("other-" + name), PhotoAfter(other, elsewhere, at));
    rows += "queries/other-" + name + ",,,,\n";
  }
  Save(dir / "queries.csv", {rows.begin(), rows.end()});
}

DemoPhotos WriteDemoPhotos(const std::filesystem::path& dir) {
  const std::vector<uint8_t> right = RenderPhoto(DemoWorld(), ShortWalk(DemoPlan()));
  const std::vector<uint8_t> elsewhere = RenderPhoto(OtherWorld(), ShortWalk(OtherPlan()));
  std::vector<uint8_t> broken = right;
  broken.resize(broken.size() / 3);
  return {Save(dir / "right.jpg", right), Save(dir / "elsewhere.jpg", elsewhere),
          Save(dir / "broken.jpg", broken)};
}

}  // namespace waystone
