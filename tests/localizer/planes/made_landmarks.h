// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/features/features.h"
#include "schema/map_data.h"
#include "tests/localizer/made_map.h"

// Points at all depths, none of which lie on a plane.
namespace waystone {

inline constexpr int64_t kLandmarkKeyframe = 7;  // keyframe of MapWithLandmarks' place, of two

struct Point {
  Eigen::Vector3d x;  // in the first keyframe's camera
  std::vector<uint8_t> descriptor;
};

// 120 of them.
std::vector<Point> MakePoints(uint64_t seed);

// px, in an image of 640x480 pixels.
Eigen::Vector2d Project(const Eigen::Vector3d& x);

// What the points give a camera that has moved by `shift`, noisy by 0.3 px, and `clutter`.
Features Look(const std::vector<Point>& points, const Eigen::Vector3d& shift, int clutter,
              uint64_t seed);

Landmarks MakeLandmarks(const Features& seen);

// The made map, with a place of two keyframes that saw no plane but MakePoints(1).
MapData MapWithLandmarks();

}  // namespace waystone
