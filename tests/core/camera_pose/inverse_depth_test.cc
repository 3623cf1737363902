// SPDX-License-Identifier: Apache-2.0
#include "core/camera_pose/inverse_depth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/random.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kRaySigma_rad = 0.002;

Isometry3d CameraAt(const Vector3d& position, double turn_rad) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = position;
  pose.linear() = Eigen::AngleAxisd(turn_rad, Vector3d::UnitY()).toRotationMatrix();
  return pose;
}

// A point `depth` ahead of the anchor, seen with noise by cameras to its left and right.
std::vector<RaySighting> SightingsOf(const Vector3d& anchor_ray, double depth, double baseline,
                                     int cameras, Random& random) {
  std::vector<RaySighting> sightings;
  for (int i = 0; i < cameras; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const Isometry3d camera =
        CameraAt({side * baseline * (1 + 0.5 * i), 0.02 * i, 0.03 * i}, -0.1 * side);
    RaySighting sighting{camera.inverse(), {}, kRaySigma_rad};
    const Vector3d noise(random.Normal(), random.Normal(), random.Normal());
    sighting.ray = ((camera.inverse() * (depth * anchor_ray)).normalized() + kRaySigma_rad * noise)
                       .normalized();
    sightings.push_back(sighting);
  }
  return sightings;
}

TEST(EstimateDepth, IsAsFarOffAsItSays) {
  Random random(1);
  double squares = 0;
  constexpr int kTrials = 500;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Vector3d ray = Vector3d(random.Uniform(-0.3, 0.3), 0.1, 1).normalized();
    const double depth = random.Uniform(1, 4);
    const auto estimate =
        EstimateDepth(ray, SightingsOf(ray, depth, 0.2, 5, random), DepthOptions{});
    ASSERT_EQ(estimate.error, DepthError::kNone);
    EXPECT_GE(estimate.inliers, 4);  // one in 3,000 is off by more than four sigmas
    const double inverse_sigma = estimate.relative_sigma / estimate.depth;
    squares += std::pow((1 / estimate.depth - 1 / depth) / inverse_sigma, 2);
  }
  EXPECT_GT(squares / kTrials, 0.8);
  EXPECT_LT(squares / kTrials, 1.25);
}

TEST(EstimateDepth, LeavesOutAWrongMatch) {
  Random random(2);
  const Vector3d ray = Vector3d(0.1, 0, 1).normalized();
  std::vector<RaySighting> sightings = SightingsOf(ray, 2, 0.2, 4, random);
  sightings[1].ray = Vector3d(0.5, 0.4, 1).normalized();
  const auto estimate = EstimateDepth(ray, sightings, DepthOptions{});
  ASSERT_EQ(estimate.error, DepthError::kNone);
  EXPECT_GE(estimate.inliers, 2);
  EXPECT_LE(estimate.inliers, 3);
  EXPECT_NEAR(estimate.depth, 2, 0.1);
}

TEST(EstimateDepth, NamesWhyThereIsNone) {
  Random random(3);
  const Vector3d ray = Vector3d::UnitZ();
  const DepthOptions options;
  EXPECT_EQ(EstimateDepth(ray, SightingsOf(ray, 2, 0.2, 1, random), options).error,
            DepthError::kTooFew);
  // Cameras that only turned, and a point that is as good as infinitely far away.
  std::vector<RaySighting> turned = SightingsOf(ray, 2, 0.2, 3, random);
  for (RaySighting& sighting : turned) {
    sighting.camera_from_anchor.translation().setZero();
    sighting.ray = sighting.camera_from_anchor * ray;
  }
  EXPECT_EQ(EstimateDepth(ray, turned, options).error, DepthError::kUncertain);
  EXPECT_EQ(EstimateDepth(ray, SightingsOf(ray, 1e5, 0.2, 4, random), options).error,
            DepthError::kUncertain);
  // Behind the cameras, by poses that are turned around.
  std::vector<RaySighting> behind = SightingsOf(ray, 2, 0.2, 4, random);
  for (RaySighting& sighting : behind) {
    sighting.camera_from_anchor.translation() = -sighting.camera_from_anchor.translation();
  }
  EXPECT_EQ(EstimateDepth(ray, behind, options).error, DepthError::kContradiction);
  // Each camera sees something else.
  std::vector<RaySighting> other = SightingsOf(ray, 2, 0.2, 4, random);
  for (size_t i = 0; i < other.size(); ++i) {
    other[i].ray = Vector3d(0.3 * std::cos(2.0 * i), 0.3 * std::sin(2.0 * i), 1).normalized();
  }
  EXPECT_EQ(EstimateDepth(ray, other, options).error, DepthError::kContradiction);
}

}  // namespace
}  // namespace waystone
