// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/fundamental.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFocal_px = 500;

// Points of a scene in two images of 640x480, then `outliers` pairs of random points.
struct MadePairs {
  std::vector<Vector2d> a;
  std::vector<Vector2d> b;
  int inliers = 0;
};

// Depths from `near` to `far`; the second camera is moved by `shift` and turned by `yaw_rad`.
MadePairs MakePairs(int inliers, int outliers, double near, double far, const Vector3d& shift,
                    double yaw_rad, uint64_t seed) {
  Random random(seed);
  const Matrix3d turn = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitY()).toRotationMatrix();
  const auto project = [](const Vector3d& x) -> Vector2d {
    return kFocal_px * x.hnormalized() + Vector2d(320, 240);
  };
  MadePairs pairs;
  while (pairs.inliers < inliers) {
    const double z = random.Uniform(near, far);
    const Vector3d x(random.Uniform(-0.6, 0.6) * z, random.Uniform(-0.45, 0.45) * z, z);
    const Vector2d noise_a(random.Normal(), random.Normal());
    const Vector2d noise_b(random.Normal(), random.Normal());
    pairs.a.emplace_back(project(x) + 0.3 * noise_a);
    pairs.b.emplace_back(project(turn * (x - shift)) + 0.3 * noise_b);
    ++pairs.inliers;
  }
  for (int i = 0; i < outliers; ++i) {
    pairs.a.emplace_back(random.Uniform(0, 640), random.Uniform(0, 480));
    pairs.b.emplace_back(random.Uniform(0, 640), random.Uniform(0, 480));
  }
  return pairs;
}

int CountTrue(const EpipolarFit& fit, const MadePairs& pairs) {
  return static_cast<int>(
      std::ranges::count_if(fit.inliers, [&](int row) { return row < pairs.inliers; }));
}

TEST(Epipolar, FindsTheInliersOfAMovingCamera) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const MadePairs pairs = MakePairs(60, 40, 2, 6, {0.5, 0, 0.2}, 0.1, seed);
    const auto fit = FindEpipolarGeometry(pairs.a, pairs.b, {});
    ASSERT_TRUE(fit) << "seed " << seed;
    EXPECT_FALSE(fit->planar) << "seed " << seed;
    EXPECT_GE(CountTrue(*fit, pairs), 57) << "seed " << seed;
    EXPECT_LE(static_cast<int>(fit->inliers.size()) - CountTrue(*fit, pairs), 5) << "seed " << seed;
    for (const int row : fit->inliers) {
      EXPECT_LE(SampsonError(fit->fundamental, pairs.a[row], pairs.b[row]), 2.0);
    }
  }
}

// Of a plane, and of a camera that only turned, the fundamental matrix is free to take in wrong
// pairs: the homography's inliers count.
TEST(Epipolar, APlaneAndATurnAreAHomographysInliers) {
  const MadePairs plane = MakePairs(60, 40, 4, 4, {0.5, 0, 0.2}, 0.1, 1);
  const MadePairs turn = MakePairs(60, 40, 2, 6, {0, 0, 0}, 0.15, 2);
  for (const MadePairs* pairs : {&plane, &turn}) {
    const auto fit = FindEpipolarGeometry(pairs->a, pairs->b, {});
    ASSERT_TRUE(fit);
    EXPECT_TRUE(fit->planar);
    EXPECT_GE(CountTrue(*fit, *pairs), 57);
    EXPECT_LE(static_cast<int>(fit->inliers.size()) - CountTrue(*fit, *pairs), 1);
  }
}

TEST(Epipolar, RandomPairsHaveFewInliers) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const MadePairs pairs = MakePairs(0, 60, 2, 6, {0.5, 0, 0}, 0, seed);
    const auto fit = FindEpipolarGeometry(pairs.a, pairs.b, {});
    EXPECT_LE(fit ? fit->inliers.size() : 0, 16u) << "seed " << seed;
  }
}

TEST(Epipolar, TooFewPairsGiveNothing) {
  const MadePairs pairs = MakePairs(7, 0, 2, 6, {0.5, 0, 0}, 0, 1);
  EXPECT_FALSE(FindEpipolarGeometry(pairs.a, pairs.b, {}));
  EXPECT_FALSE(FindEpipolarGeometry({}, {}, {}));
}

TEST(Epipolar, TheSamePairsGiveTheSameFit) {
  const MadePairs pairs = MakePairs(40, 60, 2, 6, {0.5, 0.1, 0.2}, 0.1, 3);
  const auto first = FindEpipolarGeometry(pairs.a, pairs.b, {});
  const auto again = FindEpipolarGeometry(pairs.a, pairs.b, {});
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->fundamental, again->fundamental);
  EXPECT_EQ(first->inliers, again->inliers);
}

TEST(EpipolarSignificance, IsMinusTheLogarithmOfTheFalseAlarms) {
  // 3 * 3 C(10, 9) C(9, 7) alpha^2 with alpha = 2 sqrt(2) * 2 px * 800 px / (640 px * 480 px).
  EXPECT_NEAR(EpipolarSignificance(10, 9, 2.0, 640, 480), -std::log(3 * 3 * 360 / 4608.0), 1e-9);
  EXPECT_EQ(EpipolarSignificance(100, 7, 2.0, 640, 480), 0) << "seven always fit";
  EXPECT_EQ(EpipolarSignificance(5, 9, 2.0, 640, 480), 0);
  EXPECT_EQ(EpipolarSignificance(0, 0, 2.0, 640, 480), 0);
}

TEST(EpipolarSignificance, GrowsWithTheInliersAndFallsWithTheMatches) {
  for (int inliers = 12; inliers < 60; ++inliers) {
    const double here = EpipolarSignificance(60, inliers, 2.0, 640, 480);
    EXPECT_LE(here, EpipolarSignificance(60, inliers + 1, 2.0, 640, 480)) << inliers;
    EXPECT_GE(here, EpipolarSignificance(70, inliers, 2.0, 640, 480)) << inliers;
  }
}

TEST(EpipolarSignificance, OfRandomPairsIsChance) {
  const double bound_px = EpipolarOptions{}.max_error_px;
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const MadePairs random = MakePairs(0, 30, 2, 6, {0.5, 0, 0}, 0, seed);
    const auto chance = FindEpipolarGeometry(random.a, random.b, {});
    const auto fits = static_cast<int>(chance ? chance->inliers.size() : 0);
    EXPECT_LT(EpipolarSignificance(30, fits, bound_px, 640, 480), 5) << "seed " << seed;
    const MadePairs pairs = MakePairs(20, 10, 2, 6, {0.5, 0, 0.2}, 0.1, seed);
    const auto real = FindEpipolarGeometry(pairs.a, pairs.b, {});
    ASSERT_TRUE(real);
    EXPECT_GT(EpipolarSignificance(30, static_cast<int>(real->inliers.size()), bound_px, 640, 480),
              10)
        << "seed " << seed;
  }
}

TEST(Epipolar, BadOptionsAreRefused) {
  EXPECT_THROW(EpipolarOptions{.max_error_px = 0}.Check(), MapError);
  EXPECT_THROW(EpipolarOptions{.max_samples = 0}.Check(), MapError);
  EXPECT_THROW(EpipolarOptions{.planar_share = 1.5}.Check(), MapError);
}

}  // namespace
}  // namespace waystone
