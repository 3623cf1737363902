// SPDX-License-Identifier: Apache-2.0
#include "world/rig.h"

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/options.h"

namespace waystone {
namespace {

// Columns are the camera's right, down and forward axes in the rig's frame.
Eigen::Matrix3d Axes(const Eigen::Vector3d& right, const Eigen::Vector3d& down) {
  Eigen::Matrix3d axes;
  axes << right, down, right.cross(down);
  return axes;
}

void RequireWithin(const OptionRange& range, const std::string& name, double value) {
  if (range.Contains(value)) return;
  throw MapError(ErrorCode::kBadOptions,
                 name + " is " + std::to_string(value) + "; it must be " + ToText(range));
}

}  // namespace

std::array<RigFace, 6> SixFaceRig(int width_px) {
  RequireWithin(Closed(1, 8192), "width of the rig's faces", width_px);
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
  RequireWithin(Closed(2, 16384), "width of the panorama", width_px);
  if (width_px % 2 != 0) {
    throw MapError(ErrorCode::kBadOptions,
                   "width of the panorama is " + std::to_string(width_px) + "; it must be even");
  }
  return {CameraModel::kEquirectangular, width_px, width_px / 2, {}};
}

Camera PinholeCamera(int width_px, int height_px, double field_of_view_rad) {
  RequireWithin(Closed(1, 16384), "image width", width_px);
  RequireWithin(Closed(1, 16384), "image height", height_px);
  RequireWithin(Closed(0.02, 3.1), "field_of_view_rad", field_of_view_rad);
  const double focal_px = 0.5 * width_px / std::tan(0.5 * field_of_view_rad);
  return {CameraModel::kPinhole,
          width_px,
          height_px,
          {focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1)}};
}

}  // namespace waystone
