// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/visual_odometry.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "core/base/error.h"
#include "tests/builder/appearance/drive.h"

namespace waystone {
namespace {

TEST(VisualOdometryTest, FollowsAKnownWay) {
  const VisualOdometry trajectory = FollowPanoramas(DriveSignatures(), kBand);
  ASSERT_EQ(trajectory.poses.size(), TheDrive().truth.size());
  EXPECT_LT(CompareShapes(PlacesOf(TheDrive().truth), PlacesOf(trajectory.poses)).mu, 0.03);
  const Pose2 gone = Inverse(TheDrive().truth.front()) * TheDrive().truth.back();
  EXPECT_NEAR(WrappedAngle(trajectory.poses.back().theta_rad - gone.theta_rad), 0, 0.1);
  EXPECT_EQ(trajectory.uncertain, 0);
}

// Shapes are compared whichever way they are turned. Poses begin at the first panorama's axes, so
// that steps to a wrong side of the camera lead elsewhere.
TEST(VisualOdometryTest, StepsLeadWhereTheCameraWent) {
  const VisualOdometry trajectory = FollowPanoramas(DriveSignatures(), kBand);
  const std::vector<Pose2>& truth = TheDrive().truth;
  int compared = 0;
  for (size_t i = 1; i < truth.size(); ++i) {
    const Pose2 gone = Inverse(truth.front()) * truth[i];
    if (std::hypot(gone.x, gone.y) < 1) continue;
    const Pose2& found = trajectory.poses[i];
    const double off = WrappedAngle(std::atan2(found.y, found.x) - std::atan2(gone.y, gone.x));
    EXPECT_NEAR(off, 0, 0.5) << "panorama " << i;  // a wrong side is off by a right angle
    ++compared;
  }
  EXPECT_GT(compared, 5);
}

// Eqs. (3) to (5): without longer spans the poses are the steps, one after the other.
TEST(VisualOdometryTest, PosesAreTheChainOfTheSteps) {
  std::vector<FourierSignature> signatures = DriveSignatures();
  signatures.resize(6);
  VisualOdometryOptions options;
  options.max_span = 1;
  const VisualOdometry trajectory = FollowPanoramas(signatures, kBand, options);
  Pose2 pose;
  for (const PanoramaRelation& step : trajectory.steps) {
    EXPECT_DOUBLE_EQ(step.distance, SignatureDistance(signatures[step.a], signatures[step.b], 64));
    EXPECT_NEAR(std::hypot(step.a_from_b.x, step.a_from_b.y), step.distance, 1e-9);
    pose = pose * step.a_from_b;
    EXPECT_EQ(trajectory.poses[step.b], pose);
  }
}

TEST(VisualOdometryTest, DistanceIsTheNormOfEquation2) {
  const std::vector<FourierSignature> signatures = DriveSignatures();
  EXPECT_EQ(SignatureDistance(signatures[0], signatures[0], 64), 0);
  double sum = 0;
  for (int u = 0; u < 64; ++u) {
    for (int v = 0; v < 5; ++v) {
      sum += std::pow(static_cast<double>(signatures[0].magnitudes(u, v)) -
                          static_cast<double>(signatures[9].magnitudes(u, v)),
                      2);
    }
  }
  EXPECT_NEAR(SignatureDistance(signatures[0], signatures[9], 5), std::sqrt(sum), 1e-4);
}

TEST(VisualOdometryTest, AStandingCameraStays) {
  const FourierSignature one = Signature(TheDrive().panoramas[3]);
  const VisualOdometry trajectory = FollowPanoramas({one, one, one, one}, kBand);
  for (const Pose2& pose : trajectory.poses) {
    EXPECT_NEAR(std::hypot(pose.x, pose.y), 0, 1e-6);
    EXPECT_NEAR(pose.theta_rad, 0, 1e-3);
  }
}

TEST(VisualOdometryTest, IsTheSameOnOneThread) {
  std::vector<FourierSignature> signatures = DriveSignatures();
  signatures.resize(12);
  const VisualOdometry many = FollowPanoramas(signatures, kBand);
  tbb::task_arena one(1);
  EXPECT_EQ(one.execute([&] { return FollowPanoramas(signatures, kBand); }).poses, many.poses);
}

TEST(VisualOdometryTest, OfNothingIsNothing) {
  EXPECT_TRUE(FollowPanoramas({}, kBand).poses.empty());
  EXPECT_EQ(FollowPanoramas({Signature(TheDrive().panoramas[0])}, kBand).poses.size(), 1);
}

TEST(VisualOdometryTest, RefusesOptionsOutOfRange) {
  VisualOdometryOptions options;
  options.max_span = 0;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
