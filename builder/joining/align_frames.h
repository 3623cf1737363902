// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "schema/layers/poses/pose_layer.h"

namespace waystone {

// One camera in two frames: x_to = to_from_camera x_camera, and the same with from_from_camera.
struct CameraInFrames {
  Eigen::Isometry3d to_from_camera = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d from_from_camera = Eigen::Isometry3d::Identity();
  // Standard deviation of the answered position, on each axis: that of to_from_camera, in the unit
  // of `to`; or of from_from_camera, in the unit of `from`.
  double position_sigma = 0;
  bool answered_in_from = false;
};

// x_to = scale * rotation * x_from + translation.
struct FrameChange {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  int cameras = 0;  // that agree with it
};

// The change of frame that most cameras agree with, by their rotations and positions: tried with
// each camera's rotation and each pair's distance, then fitted to all that agree by least squares.
// With `same_unit` the scale is 1. Nothing where fewer than three cameras or less than half of them
// agree, or where all that agree are at one place and the scale is wanted. Deterministic;
// thread-safe.
std::optional<FrameChange> AlignFrames(const std::vector<CameraInFrames>& cameras, bool same_unit);

// Expresses a pose layer in the other frame: poses, planes, depths and errors. Depths that can't be
// stored any more become unknown ones. Frame and unit stay as they are.
void ChangeFrame(const FrameChange& change, PoseLayer& layer);

}  // namespace waystone
