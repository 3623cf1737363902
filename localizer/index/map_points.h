// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// A feature of a map with poses in the frame of its pose layer.
struct MapPoint {
  Eigen::Vector3f x = Eigen::Vector3f::Zero();
  Eigen::Vector3f along = Eigen::Vector3f::Zero();  // one sigma, along the ray of its keyframe
  float depth = 0;  // from its keyframe; 0 where the position isn't known

  bool known() const { return depth > 0; }
};

// The features of all planes, plane after plane, and of all landmarks, keyframe after keyframe.
// Empty for a map without a pose layer. Depths of keyframes without a pose or camera are left out.
// Pure; thread-safe.
std::vector<MapPoint> LocateMapPoints(const MapData& map);

}  // namespace waystone
