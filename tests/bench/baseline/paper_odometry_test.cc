// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/paper_odometry.h"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "builder/appearance/visual_odometry.h"
#include "core/base/random.h"

namespace waystone::bench {
namespace {

// Blobs, shifted around the circle: a camera that only turned, counter-clockwise for a shift right.
cv::Mat Panorama(int shift_px) {
  constexpr int kWidth = 512;
  cv::Mat image(kWidth / 2, kWidth, CV_8U, cv::Scalar(90));
  Random random(5);
  for (int i = 0; i < 60; ++i) {
    const int x = (random.Below(kWidth) + shift_px) % kWidth;
    const cv::Rect box(x, random.Below(kWidth / 2 - 20), 12, 20);
    const double grey = random.Below(255);
    image(box & cv::Rect(0, 0, kWidth, kWidth / 2)) = grey;
  }
  return image;
}

TEST(FollowByPaper, StepsAreAsLongAsTheSignaturesDifferAndGoAhead) {
  const std::vector<FourierSignature> signatures = {Signature(Panorama(0)), Signature(Panorama(64)),
                                                    Signature(Panorama(64))};
  const std::vector<Pose2> poses = FollowByPaper(signatures, 64);
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_EQ(poses[0], Pose2{});
  EXPECT_NEAR(std::abs(poses[1].theta_rad), std::numbers::pi / 4, 0.05);
  const double length = SignatureDistance(signatures[0], signatures[1], 64);
  EXPECT_NEAR(poses[1].x, length * std::cos(poses[1].theta_rad), 1e-9);
  EXPECT_NEAR(poses[1].y, length * std::sin(poses[1].theta_rad), 1e-9);
  EXPECT_NEAR(poses[2].theta_rad, poses[1].theta_rad, 1e-6) << "the same panorama again";
  EXPECT_NEAR(poses[2].x, poses[1].x, 1e-9);
}

TEST(FollowByPaper, NothingOfNothing) { EXPECT_TRUE(FollowByPaper({}, 64).empty()); }

}  // namespace
}  // namespace waystone::bench
