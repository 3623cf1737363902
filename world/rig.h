// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>

#include "core/camera/camera.h"

namespace waystone {

// One camera of the six-face rig. Rig frame: x right, y down, z forward, all cameras at its origin.
struct RigFace {
  std::string_view name;  // "front", "right", "back", "left", "up" or "down"
  Camera camera;
  Eigen::Matrix3d rig_from_camera;  // rotation: x_rig = rig_from_camera x_camera
};

// Front, right, back, left, up, down: pinhole cameras of 90 by 90 degrees that together see the
// whole sphere; f = width / 2. Up and down are what the front camera sees when it tilts by 90
// degrees. Throws MapError(kBadOptions) unless width_px is 1 to 8192. This function and all below
// are pure; thread-safe.
std::array<RigFace, 6> SixFaceRig(int width_px);

// A panorama camera of width_px by width_px / 2. Throws MapError(kBadOptions) unless width_px is
// even and 2 to 16384.
Camera PanoramaCamera(int width_px);

// A pinhole camera with its optical axis through the middle of the image. Throws
// MapError(kBadOptions) unless the sizes are 1 to 16384 and the horizontal field of view is between
// 0.02 and 3.1 rad.
Camera PinholeCamera(int width_px, int height_px, double field_of_view_rad);

}  // namespace waystone
