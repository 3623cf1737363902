// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/camera/camera.h"

namespace waystone {

// One camera of a rig that carries several.
struct RigCamera {
  std::string name;  // "front", "cam0": also the name of its folder or file
  Camera camera;
  Eigen::Isometry3d rig_from_camera = Eigen::Isometry3d::Identity();  // x_rig = T x_camera, m
};

// Cameras that are fixed to one another and take their images at the same time. The rig's frame is
// any frame fixed to them; ours is x right, y down, z forward, as of its first or front camera.
struct Rig {
  std::vector<RigCamera> cameras;
};

// Throws MapError(kBadCamera) unless there are 1 to 64 cameras, each is sound (CheckCamera), each
// has a valid rotation, and the names differ. This function and all below are pure; thread-safe.
void CheckRig(const Rig& rig);

// Throws MapError(kBadImage) unless an image of this size (px) is one of the camera's.
void CheckImageSize(const RigCamera& camera, int width, int height);

// A single camera is a rig of one; the rig's frame is the camera's.
Rig RigOfOne(const Camera& camera);

// Six pinhole cameras of 90 by 90 degrees with one centre, which together see everything: front,
// right, back, left, up, down; f = width / 2. The rig's frame is the front camera's; up and down
// are what the front camera sees when it tilts by 90 degrees. Throws MapError(kBadCamera) unless
// width_px is 1 to 8192.
Rig CubeRig(int width_px);

}  // namespace waystone
