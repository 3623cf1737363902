// SPDX-License-Identifier: Apache-2.0
#include "core/camera/image_plane.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/geometry/rotation.h"

namespace waystone {
namespace {

// Focal lengths that a model's parameters begin with; the principal point follows them.
int FocalLengths(CameraModel model) {
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kSimpleRadial:
    case CameraModel::kRadial:
      return 1;
    case CameraModel::kEquirectangular:
      return 0;
    default:
      return 2;
  }
}

}  // namespace

std::optional<Eigen::Vector2d> OnImagePlane(const Camera& camera, const Eigen::Vector2d& pixel) {
  constexpr double kLeastAhead = 0.05;  // z of the unit ray
  const Eigen::Vector3d ray = Unproject(camera, pixel);
  if (ray.z() < kLeastAhead) return std::nullopt;
  return Eigen::Vector2d(ray.x() / ray.z(), ray.y() / ray.z());
}

Eigen::Matrix3d ImageFromCamera(const Camera& camera) {
  const int focal_lengths = FocalLengths(camera.model);
  WS_CHECK(focal_lengths > 0, "a panorama has no linear part");
  const double* centre = camera.params.data() + focal_lengths;
  Eigen::Matrix3d k;
  k << camera.params[0], 0, centre[0], 0, camera.params[focal_lengths - 1], centre[1], 0, 0, 1;
  return k;
}

Camera ScaledCamera(const Camera& camera, int width) {
  WS_CHECK(width >= 1, "a camera without pixels");
  if (width == camera.width) return camera;
  const double scale = static_cast<double>(width) / camera.width;
  Camera scaled = camera;
  scaled.width = width;
  scaled.height = std::max(1, static_cast<int>(std::lround(scale * camera.height)));
  const int focal_lengths = FocalLengths(camera.model);
  if (focal_lengths == 0) return scaled;
  for (int i = 0; i < focal_lengths; ++i) scaled.params[i] *= scale;
  for (int i = focal_lengths; i < focal_lengths + 2; ++i) {
    scaled.params[i] = (scaled.params[i] + 0.5) * scale - 0.5;
  }
  return scaled;
}

double RadiansPerPixel(const Camera& camera) {
  const Eigen::Vector2d middle(0.5 * camera.width, 0.5 * camera.height);
  return AngleBetween(Unproject(camera, middle),
                      Unproject(camera, middle + Eigen::Vector2d::UnitX()));
}

}  // namespace waystone
