// SPDX-License-Identifier: Apache-2.0
#include "core/camera/scaled_camera.h"

#include <gtest/gtest.h>

namespace waystone {
namespace {

// Borders of pixels, which lie at -1/2, scale with the image.
TEST(ScaledCamera, SeesTheSameRaysAtScaledPixels) {
  const Camera cameras[] = {
      {CameraModel::kSimplePinhole, 640, 480, {500, 322, 241}},
      {CameraModel::kPinhole, 640, 480, {500, 510, 322, 241}},
      {CameraModel::kSimpleRadial, 640, 480, {500, 322, 241, -0.1}},
      {CameraModel::kRadial, 640, 480, {500, 322, 241, -0.1, 0.02}},
      {CameraModel::kOpenCv, 640, 480, {500, 510, 322, 241, -0.1, 0.02, 0.001, 0.002}},
      {CameraModel::kOpenCvFisheye, 640, 480, {300, 305, 322, 241, 0.01, 0.002, 0.001, 0.002}},
      {CameraModel::kEquirectangular, 640, 320, {}},
  };
  for (const Camera& camera : cameras) {
    const Camera half = ScaledCamera(camera, 320);
    EXPECT_EQ(half.width, 320);
    EXPECT_EQ(half.height, camera.height / 2);
    for (const Eigen::Vector3d& ray : {Eigen::Vector3d(0.1, -0.2, 1), {-0.4, 0.3, 1.1}}) {
      const Eigen::Vector2d at = Project(camera, ray).value();
      const Eigen::Vector2d scaled = Project(half, ray).value();
      EXPECT_LT(((scaled.array() + 0.5) * 2 - 0.5 - at.array()).abs().maxCoeff(), 1e-9)
          << NameOf(camera.model);
    }
  }
}

}  // namespace
}  // namespace waystone
