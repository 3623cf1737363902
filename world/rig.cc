// SPDX-License-Identifier: Apache-2.0
#include "world/rig.h"

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/option_range.h"

namespace waystone {
namespace {

// Columns are the camera's right, down and forward axes in the rig's frame.
Eigen::Matrix3d Axes(const Eigen::Vector3d& right, const Eigen::Vector3d& down) {
  Eigen::Matrix3d axes;
  axes << right, down, right.cross(down);
  return axes;
}

}  // namespace

std::array<RigFace, 6> SixFaceRig(int width_px) {
  CheckRange("width of the rig's faces", width_px, 1, 8192);
  const Camera camera = PinholeCamera(width_px, width_px, 0.5 * std::numbers::pi);
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  return {{{"front", camera, Axes(x, y)},
           {"right", camera, Axes(-z, y)},
           {"back", camera, Axes(-x, y)},
           {"left", camera, Axes(z, y)},
           {"up", camera, Axes(x, z)},
           {"down", camera, Axes(x, -z)}}};
}

Camera PanoramaCamera(int width_px) {
  CheckRange("width of the panorama", width_px, 2, 16384);
  if (width_px % 2 != 0) {
    throw MapError(ErrorCode::kBadOptions,
                   "width of the panorama is " + std::to_string(width_px) + "; it must be even");
  }
  return {CameraModel::kEquirectangular, width_px, width_px / 2, {}};
}

Camera PinholeCamera(int width_px, int height_px, double field_of_view_rad) {
  CheckRange("image width", width_px, 1, 16384);
  CheckRange("image height", height_px, 1, 16384);
  CheckRange("field_of_view_rad", field_of_view_rad, 0.02, 3.1);
  const double focal_px = 0.5 * width_px / std::tan(0.5 * field_of_view_rad);
  return {CameraModel::kPinhole,
          width_px,
          height_px,
          {focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1)}};
}

}  // namespace waystone
