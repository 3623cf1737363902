// SPDX-License-Identifier: Apache-2.0
#include "world/truth.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

class TwoViews : public testing::Test {
 protected:
  const World& world_ = TwoRoomWorld();
  const Camera camera_ = PinholeCamera(320, 240, 1.2);
  const Eigen::Isometry3d a_ = WorldFromCamera({1.4, 2.0, 1.4}, 0.3, 0.05, 0.03);
  const Eigen::Isometry3d b_ = WorldFromCamera({1.7, 1.6, 1.5}, 0.45, 0.0, -0.02);
  // A little blur, so that interpolation between pixels loses nothing.
  const RenderedFrame frame_a_ = Render(world_, camera_, a_, {.lens_blur_px = 1.0});
  const RenderedFrame frame_b_ = Render(world_, camera_, b_, {.lens_blur_px = 1.0});
};

TEST_F(TwoViews, HomographyMovesPointsOfThePlaneAndTellsTheirDepth) {
  for (const VisiblePlane& seen : VisiblePlanes(frame_a_.plane_ids)) {
    const WorldPlane& plane = world_.PlaneById(seen.plane);
    const Eigen::Matrix3d b_from_a = PlaneHomography(plane, camera_, a_, b_);
    const Eigen::Matrix3d a_from_b = PlaneHomography(plane, camera_, b_, a_);
    EXPECT_TRUE((a_from_b * b_from_a).isApprox(Eigen::Matrix3d::Identity(), 1e-9));
    for (const double u : {0.2, 0.7}) {
      const Eigen::Vector3d point = plane.origin + u * plane.size_m.x() * plane.u_axis +
                                    0.5 * plane.size_m.y() * plane.v_axis;
      const Eigen::Vector3d in_a = a_.inverse() * point;
      const Eigen::Vector3d in_b = b_.inverse() * point;
      const auto pixel_a = Project(camera_, in_a);
      const auto pixel_b = Project(camera_, in_b);
      if (!pixel_a || !pixel_b) continue;
      const Eigen::Vector3d moved = b_from_a * pixel_a->homogeneous();
      EXPECT_NEAR((moved.hnormalized() - *pixel_b).norm(), 0.0, 1e-6);
      EXPECT_NEAR(moved.z(), in_b.z() / in_a.z(), 1e-9);
    }
  }
}

TEST_F(TwoViews, ImageFromPlaneProjectsThePlanesCoordinates) {
  for (const WorldPlane& plane : world_.planes()) {
    const Eigen::Vector3d uv(0.3, 0.4, 1.0);
    const Eigen::Vector3d point =
        a_.inverse() * (plane.origin + uv.x() * plane.u_axis + uv.y() * plane.v_axis);
    const Eigen::Vector3d pixel = ImageFromPlane(plane, camera_, a_) * uv;
    EXPECT_NEAR(pixel.z(), point.z(), 1e-9);
    const auto expected = Project(camera_, point);
    if (expected) {
      EXPECT_NEAR((pixel.hnormalized() - *expected).norm(), 0.0, 1e-6);
    }
  }
}

TEST_F(TwoViews, WarpedPictureAndPlaneIdsMatchTheOtherView) {
  int checked = 0;
  for (const VisiblePlane& seen : VisiblePlanes(frame_b_.plane_ids)) {
    if (seen.pixels < 3000) continue;
    const Eigen::Matrix3d a_from_b = PlaneHomography(world_.PlaneById(seen.plane), camera_, b_, a_);
    cv::Mat h(3, 3, CV_64F);
    for (int i = 0; i < 9; ++i) h.at<double>(i / 3, i % 3) = a_from_b(i / 3, i % 3);
    cv::Mat warped;
    cv::Mat ids;
    const int flags = cv::WARP_INVERSE_MAP;
    cv::warpPerspective(frame_a_.grey, warped, h, frame_b_.grey.size(), flags | cv::INTER_LINEAR);
    cv::warpPerspective(frame_a_.plane_ids, ids, h, frame_b_.grey.size(),
                        flags | cv::INTER_NEAREST);
    cv::Mat both = (ids == seen.plane) & (frame_b_.plane_ids == seen.plane);
    cv::erode(both, both, cv::Mat::ones(5, 5, CV_8U));
    const int pixels = cv::countNonZero(both);
    if (pixels < 1000) continue;
    ++checked;
    const double mean = cv::norm(warped, frame_b_.grey, cv::NORM_L1, both) / pixels;
    // The same without the homography: what chance gives.
    const double chance = cv::norm(frame_a_.grey, frame_b_.grey, cv::NORM_L1, both) / pixels;
    EXPECT_LT(mean, 0.2 * chance) << "plane " << seen.plane;
  }
  EXPECT_GE(checked, 3);
}

TEST(Truth, ManhattanDirectionsAreTheAxesInTheCamera) {
  const Eigen::Isometry3d pose = WorldFromCamera({1, 1, 1}, 0.7, 0.2, 0.1);
  const Eigen::Matrix3d directions = ManhattanDirections(pose);
  EXPECT_TRUE((pose.linear() * directions).isApprox(Eigen::Matrix3d::Identity(), 1e-12));
  const Eigen::Matrix3d level = ManhattanDirections(WorldFromCamera({1, 1, 1}, 0.0));
  EXPECT_TRUE(level.col(0).isApprox(Eigen::Vector3d::UnitZ())) << "east is ahead";
  EXPECT_TRUE(level.col(1).isApprox(-Eigen::Vector3d::UnitX())) << "north is to the left";
  EXPECT_TRUE(level.col(2).isApprox(-Eigen::Vector3d::UnitY())) << "up is up";
}

TEST(Truth, VisiblePlanesCountEveryPixel) {
  cv::Mat ids(4, 5, CV_16UC1, cv::Scalar(7));
  ids.at<uint16_t>(0, 0) = 2;
  const std::vector<VisiblePlane> expected = {{2, 1}, {7, 19}};
  EXPECT_EQ(VisiblePlanes(ids), expected);
}

TEST(Truth, RefusesCamerasThatAreNotPinholes) {
  EXPECT_THROW(CalibrationMatrix(PanoramaCamera(64)), CheckFailure);
  const Camera simple{CameraModel::kSimplePinhole, 64, 48, {50.0, 31.5, 23.5}};
  EXPECT_EQ(CalibrationMatrix(simple)(1, 1), 50.0);
  EXPECT_EQ(CalibrationMatrix(simple)(1, 2), 23.5);
}

}  // namespace
}  // namespace waystone
