// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/task_arena.h>

#include <cmath>
#include <vector>

#include "builder/frames/frame_pipeline.h"
#include "builder/orientation/orientation_layer.h"
#include "builder/sources/memory_source.h"
#include "tests/builder/sources/frames_of_images.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {

// Around a corner to the right, in a corridor 1.5 m wide.
inline constexpr const char* kCornerPlan = R"(
####################
#..................#
#..................#
#..................#
################...#
################...#
################...#
################...#
################...#
################...#
####################
)";

struct CornerWalk {
  std::vector<Eigen::Isometry3d> poses;
  std::vector<cv::Mat> images;
  Camera camera = PinholeCamera(320, 240, 1.3);
};

// Rendered once for all tests.
inline const CornerWalk& Corner() {
  static const CornerWalk corner = [] {
    CornerWalk made;
    WorldOptions look;
    look.texel_m = 0.01;
    look.texture_richness = 0.4;
    const World world(ParseFloorPlan(kCornerPlan), look);
    WalkOptions options;
    options.gaze_rad = 0;
    options.sway = 0.3;
    options.step_m = 0.12;
    options.turn_rad = 0.12;
    const Walk walk = WalkThrough(world.plan(), {{2.5, 2.5}, {17.5, 2.5}, {17.5, 9}}, options);
    const Renderer renderer(made.camera);
    for (const WalkFrame& frame : walk.frames) {
      made.poses.push_back(frame.world_from_camera);
      made.images.push_back(renderer.Render(world, frame.world_from_camera).grey);
    }
    return made;
  }();
  return corner;
}

struct BuiltOrientation {
  OrientationLayer layer;
  OrientationReport report;
};

inline BuiltOrientation BuildOrientation(const std::vector<cv::Mat>& images,
                                         int threads = tbb::task_arena::automatic,
                                         const ProgressCallback& progress = {},
                                         const OrientationOptions& options = {}) {
  MemorySource source(
      {.name = "corner", .frames = FramesOfImages(images), .camera = Corner().camera});
  OrientationLayerBuilder builder(options);
  tbb::task_arena arena(threads);
  MapData map = arena.execute([&] { return BuildLayer({&source}, builder, progress); });
  return {std::move(*map.orientation), builder.report()};
}

inline MapData MapWith(OrientationLayer layer) {
  MapData map;
  map.sequences.push_back({.id = {1}, .name = "corner", .kind = "folder", .camera = {}});
  map.orientation = std::move(layer);
  return map;
}

inline double TrueHeading(int i) {
  const Eigen::Vector3d gaze = Corner().poses[i].linear().col(2);
  return std::atan2(gaze.y(), gaze.x());  // the walk starts along the world's x
}

}  // namespace waystone
