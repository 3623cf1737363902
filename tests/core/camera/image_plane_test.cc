// SPDX-License-Identifier: Apache-2.0
#include "core/camera/image_plane.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

namespace waystone {
namespace {

TEST(ImagePlane, IsWhereRaysCrossIt) {
  const Camera camera{CameraModel::kPinhole, 640, 480, {500, 510, 322, 241}};
  const auto x = OnImagePlane(camera, {372, 292});
  ASSERT_TRUE(x.has_value());
  EXPECT_NEAR(x->x(), 0.1, 1e-12);
  EXPECT_NEAR(x->y(), 0.1, 1e-12);
  const Eigen::Vector3d px = ImageFromCamera(camera) * x->homogeneous();
  EXPECT_TRUE(px.isApprox(Eigen::Vector3d(372, 292, 1), 1e-12)) << px.transpose();
  const Camera one_focal_length{CameraModel::kRadial, 640, 480, {500, 322, 241, -0.1, 0.02}};
  EXPECT_EQ(ImageFromCamera(one_focal_length)(1, 1), 500);
  EXPECT_EQ(ImageFromCamera(one_focal_length)(1, 2), 241);
  // A fisheye sees beside itself, where there is no image plane.
  const Camera fisheye{CameraModel::kOpenCvFisheye, 640, 640, {200, 200, 320, 320, 0, 0, 0, 0}};
  EXPECT_FALSE(OnImagePlane(fisheye, {636, 320}).has_value());
}

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
