// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/pose2.h"
#include "schema/layers/poses/pose_layer.h"

namespace waystone {

// The mean direction of the tops of a layer's keyframes and panoramas, of unit length, in its
// frame; nothing where they differ too much. Pure; thread-safe, as all functions here.
std::optional<Eigen::Vector3d> EstimateUp(const PoseLayer& layer);

// The frame of a pose layer as seen from above: unit vectors that point to the right, to the top
// and out of the picture.
struct Horizontal {
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d top = Eigen::Vector3d::UnitY();
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();

  Eigen::Vector2d Of(const Eigen::Vector3d& point) const {
    return {right.dot(point), top.dot(point)};
  }
  // A camera's position, and the direction in which it looks as the angle from the right towards
  // the top.
  Pose2 Of(const CameraPose& pose) const;
};

// Up is the axis of the frame within 20 degrees of EstimateUp, or else EstimateUp itself; z where
// it isn't known. The frame's x points to the right unless it is near up. In a frame with z up,
// right and top are x and y.
Horizontal HorizontalOf(const PoseLayer& layer);

}  // namespace waystone
