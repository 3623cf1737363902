// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/poses/pose_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace waystone {
namespace {

TEST(DepthCode, IsWithinItsSteps) {
  for (double depth = 2e-5; depth < 6e4; depth *= 1.37) {
    for (const double sigma : {0.0, 0.001, 0.25, 1.0}) {
      const DepthCode code = EncodeDepth(depth, sigma);
      ASSERT_TRUE(code.known());
      EXPECT_NEAR(DepthOf(code) / depth, 1, 0.00018);
      EXPECT_GE(RelativeSigmaOf(code), sigma);  // never surer than it was
      EXPECT_NEAR(RelativeSigmaOf(code), sigma, 2e-5);
    }
  }
  EXPECT_EQ(RelativeSigmaOf(EncodeDepth(1, 7)), 1);
}

TEST(DepthCode, IsUnknownForWhatItCantHold) {
  for (const double depth : {0.0, -1.0, 1e-6, 1e6, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(EncodeDepth(depth, 0.1).known()) << depth;
  }
  EXPECT_FALSE(EncodeDepth(1, std::numeric_limits<double>::quiet_NaN()).known());
  EXPECT_FALSE(DepthCode{}.known());
}

TEST(PoseLayer, FindsTheKeyframesThatHavePoses) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(3.5, Eigen::Vector3d::UnitY()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(1, 2, 3);
  PoseLayer layer;
  layer.keyframes = {MakeKeyframePose({3}, pose), MakeKeyframePose({7}, pose)};
  EXPECT_GE(layer.keyframes[0].rotation.w(), 0);
  ASSERT_NE(layer.Find(KeyframeId{7}), nullptr);
  EXPECT_TRUE(layer.Find(KeyframeId{7})->frame_from_camera().isApprox(pose, 1e-12));
  EXPECT_EQ(layer.Find(KeyframeId{5}), nullptr);
  EXPECT_EQ(layer.Find(KeyframeId{8}), nullptr);
}

}  // namespace
}  // namespace waystone
