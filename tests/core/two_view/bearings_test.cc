// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/bearings.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/two_view/relative_rotation.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

std::vector<cv::Mat> Pictures(const Rig& rig, const Eigen::Isometry3d& world_from_rig) {
  std::vector<cv::Mat> images;
  for (const RigCamera& camera : rig.cameras) {
    images.push_back(
        Render(TwoRoomWorld(), camera.camera, world_from_rig * camera.rig_from_camera).grey);
  }
  return images;
}

TEST(Bearings, MotionBetweenTwoPlacesOfARoom) {
  const Rig rig = CubeRig(200);
  const Eigen::Isometry3d a = WorldFromCamera({1.2, 1.6, 1.4}, 0.3);
  const Eigen::Isometry3d b = WorldFromCamera({1.7, 2.1, 1.4}, 1.4, 0.1, 0.05);
  const RelativePose pose = FindRelativePose(MatchBearings(ExtractBearings(rig, Pictures(rig, a)),
                                                           ExtractBearings(rig, Pictures(rig, b))));
  ASSERT_TRUE(pose.accepted()) << NameOf(pose.error);
  const Eigen::Isometry3d truth = b.inverse() * a;
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(truth.linear() * pose.b_from_a.transpose()));
  EXPECT_LT(turn.angle(), 0.5 * kDegree);
  EXPECT_GT(pose.translation.dot(truth.translation().normalized()), std::cos(3 * kDegree));
}

TEST(Bearings, BucketsSpreadTheFeatures) {
  const Rig rig = RigOfOne(PinholeCamera(320, 240, 1.2));
  const auto images = Pictures(rig, InWestRoom(2.0));
  BearingFeatureOptions options{.max_kept = 60};
  const auto cells = [&](int buckets) {
    options.buckets = buckets;
    std::set<std::pair<int, int>> filled;
    for (const Keypoint& at : ExtractBearings(rig, images, options).keypoints) {
      filled.emplace(static_cast<int>(at.x_px / 40), static_cast<int>(at.y_px / 40));
    }
    return filled.size();
  };
  EXPECT_GT(cells(8), cells(1));
}

TEST(Bearings, RaysAreThoseOfTheCameras) {
  const Rig rig = CubeRig(160);
  const BearingFeatures features = ExtractBearings(rig, Pictures(rig, InWestRoom()));
  ASSERT_GT(features.size(), 50);
  for (int i = 0; i < features.size(); ++i) {
    const RigCamera& camera = rig.cameras[features.camera[i]];
    const auto pixel = Project(camera.camera, camera.rig_from_camera.inverse() * features.rays[i]);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), features.keypoints[i].x_px, 1e-3);
  }
}

TEST(Bearings, BlackAndMissingImagesGiveNothing) {
  const Rig rig = CubeRig(64);
  std::vector<cv::Mat> images(6, cv::Mat(64, 64, CV_8UC1, cv::Scalar(0)));
  images[2] = cv::Mat();
  const BearingFeatures none = ExtractBearings(rig, images);
  EXPECT_EQ(none.size(), 0);
  EXPECT_FALSE(FindRelativePose(MatchBearings(none, none)).accepted());
  images[0] = cv::Mat(64, 65, CV_8UC1, cv::Scalar(0));
  EXPECT_THROW(ExtractBearings(rig, images), MapError);
}

}  // namespace
}  // namespace waystone
