// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/calibrated_maps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/e2e/shared_map.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// Cells of half a metre: the room's corner is at (7.5, 3.5).
constexpr const char* kSmallRoom = R"(
################
#..............#
#..............#
#..............#
#..............#
#..............#
#..............#
################
)";

constexpr const char* kAroundACorner = R"(
##############
#............#
#............#
#............#
##########...#
##########...#
##########...#
##########...#
##########...#
##############
)";

std::string Numbered(int i) { return (i < 100 ? i < 10 ? "00" : "0" : "") + std::to_string(i); }

CornerWalk MakeCorner() {
  CornerWalk walk;
  const fs::path folder = TheMap().folder / "corner";
  walk.map = folder / "walls.db";
  walk.images = folder / "images";
  walk.camera = folder / "camera.yaml";
  walk.corner = {7.5, 3.5};
  fs::create_directories(walk.images);
  const Camera camera = PinholeCamera(640, 480, 1.2);
  WorldOptions look;
  look.seed = 2;  // other posters than in the demo's building
  look.trim = true;
  const World world(ParseFloorPlan(kSmallRoom), look);
  const Renderer renderer(camera);
  for (int i = 0; i < 14; ++i) {
    const double aside = 0.12 * i;
    walk.poses.push_back(
        WorldFromCamera({5.0 + aside, 2.1 - aside, 1.3}, std::numbers::pi / 4 + 0.02 * (i % 3)));
    cv::imwrite((walk.images / (Numbered(i) + ".jpg")).string(),
                renderer.Render(world, walk.poses.back()).grey);
  }
  const std::string f = std::to_string(camera.params[0]);
  WriteFile(walk.camera,
            "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [" + f +
                ", 0, 319.5, 0, " + f +
                ", 239.5, 0, 0, 1]}\ndistortion_model: plumb_bob\n"
                "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n");
  const RunResult built = RunWaystone({"build", walk.images, "-o", walk.map, "--camera",
                                       walk.camera, "--layers", "planes,orientation"});
  EXPECT_EQ(built.code, 0) << built.err;
  return walk;
}

fs::path MakeTurns() {
  const fs::path folder = TheMap().folder / "turns";
  WorldOptions look;
  look.texel_m = 0.02;
  look.texture_richness = 0.3;
  const World world(ParseFloorPlan(kAroundACorner), look);
  WalkOptions options;
  options.gaze_rad = 0;
  options.step_m = 0.15;
  options.turn_rad = 0.12;
  const Walk walk = WalkThrough(world.plan(), {{2.5, 2.5}, {11.5, 2.5}, {11.5, 8}}, options);
  for (const RigFace& face : SixFaceRig(160)) {
    const fs::path images = folder / face.name;
    fs::create_directories(images);
    const Renderer renderer(face.camera);
    for (size_t i = 0; i < walk.frames.size(); ++i) {
      Eigen::Isometry3d pose = walk.frames[i].world_from_camera;
      pose.linear() = pose.linear() * face.rig_from_camera;
      cv::imwrite((images / (Numbered(static_cast<int>(i)) + ".png")).string(),
                  renderer.Render(world, pose).grey);
    }
  }
  fs::path map = TheMap().folder / "turns.db";
  const RunResult built = RunWaystone({"build", folder, "-o", map});
  EXPECT_EQ(built.code, 0) << built.err;
  return map;
}

PosedHall MakePosedHall() {
  PosedHall hall{TheMap().folder / "hall.db", TheMap().folder / "hall"};
  const RunResult written = RunWaystone({"demo", "--write", hall.walk});
  EXPECT_EQ(written.code, 0) << written.err;
  const RunResult built = RunWaystone(
      {"build", hall.walk / "images", "-o", hall.map, "--camera", hall.walk / "camera.yaml",
       "--poses", hall.walk / "poses.csv", "--unit", "metres", "--frame", "hall", "--every", "2"});
  EXPECT_EQ(built.code, 0) << built.err;
  return hall;
}

}  // namespace

const CornerWalk& TheCorner() {
  static const CornerWalk walk = MakeCorner();
  return walk;
}

const fs::path& TheTurns() {
  static const fs::path map = MakeTurns();
  return map;
}

const PosedHall& ThePosedHall() {
  static const PosedHall hall = MakePosedHall();
  return hall;
}

}  // namespace waystone
