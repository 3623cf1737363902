// SPDX-License-Identifier: Apache-2.0
#include "core/trajectory/trajectory_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"

namespace waystone {
namespace {

// A quarter of a circle of radius 2 m, a frame every half second.
Trajectory Bend(int frames, double first_s = 0) {
  Trajectory bend;
  bend.has_headings = true;
  for (int i = 0; i < frames; ++i) {
    const double angle = 1.5 * i / (frames - 1);
    bend.times_s.push_back(first_s + 0.5 * i);
    bend.poses.push_back({2 * std::sin(angle), 2 - 2 * std::cos(angle), angle});
  }
  return bend;
}

TEST(TrajectoryError, TheSameElsewhereHasNone) {
  const Trajectory truth = Bend(20);
  Trajectory estimate = truth;
  for (Pose2& pose : estimate.poses) pose = Pose2{5, -3, 1} * pose;
  const TrajectoryError error = CompareTrajectories(estimate, truth);
  EXPECT_EQ(error.pairs, 20u);
  EXPECT_LT(error.shape.mu, 1e-12);
  EXPECT_LT(error.ate_m, 1e-9);
  EXPECT_LT(error.rpe_m.value(), 1e-9);
  EXPECT_LT(error.rpe_rad.value(), 1e-9);
}

TEST(TrajectoryError, ScaleCountsForTheMetricErrorAlone) {
  const Trajectory truth = Bend(20);
  Trajectory estimate = truth;
  for (Pose2& pose : estimate.poses) pose.x *= 2, pose.y *= 2;
  const TrajectoryError error = CompareTrajectories(estimate, truth);
  EXPECT_LT(error.shape.mu, 1e-12);
  EXPECT_LT(error.ate_scaled_m, 1e-9);
  EXPECT_GT(error.ate_m, 0.5);
  const double step = 2 * 2 * std::sin(1.5 / 19 / 2);
  EXPECT_NEAR(error.rpe_m.value(), step, 1e-9);
  EXPECT_LT(error.rpe_rad.value(), 1e-9);
}

TEST(TrajectoryError, PairsByTheNearestTimeStamp) {
  Trajectory estimate = Bend(20, 0.01);
  estimate.times_s[4] += 0.2;  // between two true ones
  const auto pairs = Associate(estimate, Bend(20));
  EXPECT_EQ(pairs.size(), 19u);
  EXPECT_EQ(pairs[4], (std::pair<size_t, size_t>(5, 5)));
  EXPECT_EQ(Associate(Bend(10, 2), Bend(20)).front(), (std::pair<size_t, size_t>(0, 4)));
}

TEST(TrajectoryError, PairsByOrderWithoutTimes) {
  Trajectory estimate = Bend(7, 1000);
  estimate.times_s.clear();
  estimate.has_headings = false;
  const TrajectoryError error = CompareTrajectories(estimate, Bend(7));
  EXPECT_EQ(error.pairs, 7u);
  EXPECT_FALSE(error.rpe_m);
}

TEST(TrajectoryError, WhatCantBePairedIsRefused) {
  EXPECT_THROW(Associate(Bend(20, 1000), Bend(20)), MapError);
  EXPECT_THROW(Associate(Bend(2), Bend(2)), MapError);
  Trajectory untimed = Bend(19);
  untimed.times_s.clear();
  EXPECT_THROW(Associate(untimed, Bend(20)), MapError);
  EXPECT_THROW(Associate(Bend(9), Bend(9), {.max_difference_s = 0}), MapError);
}

}  // namespace
}  // namespace waystone
