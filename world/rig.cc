// SPDX-License-Identifier: Apache-2.0
#include "world/rig.h"

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/options.h"
#include "core/camera/cube_faces.h"
#include "core/camera/rig.h"

namespace waystone {
namespace {

void RequireWithin(const OptionRange& range, const std::string& name, double value) {
  if (range.Contains(value)) return;
  throw MapError(ErrorCode::kBadOptions,
                 name + " is " + std::to_string(value) + "; it must be " + ToText(range));
}

}  // namespace

std::array<RigFace, 6> SixFaceRig(int width_px) {
  RequireWithin(Closed(1, 8192), "width of the rig's faces", width_px);
  const Camera camera = PinholeCamera(width_px, width_px, 0.5 * std::numbers::pi);
  const Rig cube = CubeRig(width_px);
  std::array<RigFace, 6> rig;
  for (size_t i = 0; i < rig.size(); ++i) {
    rig[i] = {NameOf(static_cast<CubeFace>(i)), camera, cube.cameras[i].rig_from_camera.linear()};
  }
  return rig;
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
