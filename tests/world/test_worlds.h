// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {

// Two rooms, 3 m by 3 m each, one west and one east of a wall with a door in it.
inline FloorPlan TwoRooms() {
  return ParseFloorPlan(R"(
###############
#......#......#
#......#......#
#..1...D...2..#
#......D......#
#......#......#
#......#......#
###############
)");
}

// Coarser than the default, so that tests are fast.
inline WorldOptions TestOptions() {
  WorldOptions options;
  options.texel_m = 0.01;
  return options;
}

inline const World& TwoRoomWorld() {
  static const World world(TwoRooms(), TestOptions());
  return world;
}

inline Camera SmallCamera() { return PinholeCamera(160, 120, 1.2); }

// In the middle of the west room, looking east through the door.
inline Eigen::Isometry3d InWestRoom(double yaw_rad = 0.0, double pitch_rad = 0.0) {
  return WorldFromCamera({1.5, 2.0, 1.4}, yaw_rad, pitch_rad, 0.02);
}

inline bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

}  // namespace waystone
