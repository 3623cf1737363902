// SPDX-License-Identifier: Apache-2.0
#include "core/camera/scaled_camera.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

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

Camera ScaledCamera(const Camera& camera, int width) {
  WS_CHECK(width >= 1, "a camera without pixels");
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

}  // namespace waystone
