// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/relative_rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/geometry/angle.h"
#include "core/two_view/five_point.h"

namespace waystone {
namespace {

Eigen::Vector3d RandomUnit(Random& random) {
  return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
}

struct Scene {
  Eigen::Matrix3d b_from_a;
  Eigen::Vector3d translation;  // b's frame
  MatchedRays rays;
};

// Points all around two rigs, seen with errors, and matches of nothing with nothing.
Scene MakeScene(Random& random, int good, int wrong, double noise_rad, double step_m) {
  Scene scene;
  scene.b_from_a =
      Eigen::AngleAxisd(random.Uniform(0, std::numbers::pi), RandomUnit(random)).toRotationMatrix();
  scene.translation = RandomUnit(random) * step_m;
  const auto seen = [&](const Eigen::Vector3d& ray) -> Eigen::Vector3d {
    return (ray.normalized() +
            noise_rad * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()))
        .normalized();
  };
  for (int i = 0; i < good; ++i) {
    const Eigen::Vector3d x_a = RandomUnit(random) * random.Uniform(2, 8);
    scene.rays.a.push_back(seen(x_a));
    scene.rays.b.push_back(seen(scene.b_from_a * x_a + scene.translation));
  }
  for (int i = 0; i < wrong; ++i) {
    scene.rays.a.push_back(RandomUnit(random));
    scene.rays.b.push_back(RandomUnit(random));
  }
  return scene;
}

double RotationError(const Scene& scene, const RelativePose& pose) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(scene.b_from_a * pose.b_from_a.transpose())).angle();
}

TEST(FivePoints, TruthIsAmongTheSolutions) {
  Random random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const Scene scene = MakeScene(random, 5, 0, 0, 1);
    std::array<Eigen::Vector3d, 5> a;
    std::array<Eigen::Vector3d, 5> b;
    std::copy_n(scene.rays.a.begin(), 5, a.begin());
    std::copy_n(scene.rays.b.begin(), 5, b.begin());
    const std::vector<Eigen::Matrix3d> solutions = SolveFivePoints(a, b);
    EXPECT_LE(solutions.size(), 10u);
    double nearest = 10;
    for (const Eigen::Matrix3d& e : solutions) {
      EXPECT_NEAR(e.norm(), 1, 1e-12);
      for (int i = 0; i < 5; ++i) EXPECT_NEAR(b[i].dot(e * a[i]), 0, 1e-12);
      for (const Motion& motion : DecomposeEssential(e)) {
        nearest = std::min(nearest, (motion.b_from_a - scene.b_from_a).norm() +
                                        (motion.translation - scene.translation).norm());
      }
    }
    EXPECT_LT(nearest, 1e-5) << trial;
  }
}

// Turning on the spot leaves the direction free: whatever is found, it is finite.
TEST(FivePoints, DegenerateSamplesGiveNothingOrFiniteMatrices) {
  Random random(2);
  const Scene turned = MakeScene(random, 5, 0, 0, 0);
  std::array<Eigen::Vector3d, 5> a;
  std::array<Eigen::Vector3d, 5> b;
  std::copy_n(turned.rays.a.begin(), 5, a.begin());
  std::copy_n(turned.rays.b.begin(), 5, b.begin());
  const auto expect_finite = [&] {
    for (const Eigen::Matrix3d& e : SolveFivePoints(a, b)) EXPECT_TRUE(e.allFinite());
  };
  expect_finite();
  a[4] = a[3];
  b[4] = b[3];
  expect_finite();
  a.fill(a[0]);
  b.fill(b[0]);
  expect_finite();
  a.fill(Eigen::Vector3d::Zero());
  expect_finite();
  a.fill(Eigen::Vector3d::Constant(std::nan("")));
  expect_finite();
}

TEST(RelativePose, FindsAnyMotionAmongWrongMatches) {
  Random random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Scene scene = MakeScene(random, 60, 60, 0.0005, 1);
    const RelativePose pose = FindRelativePose(scene.rays);
    ASSERT_TRUE(pose.accepted()) << NameOf(pose.error);
    EXPECT_LT(RotationError(scene, pose), 0.15 * kDegree) << trial;
    EXPECT_GT(pose.translation.dot(scene.translation), std::cos(1 * kDegree)) << trial;
    EXPECT_GE(pose.inliers.size(), 55u);
    EXPECT_LE(pose.inliers.size(), 64u);
  }
}

TEST(RelativePose, ExactRaysGiveTheExactMotion) {
  Random random(3);
  const Scene scene = MakeScene(random, 30, 0, 0, 1);
  const RelativePose pose = FindRelativePose(scene.rays);
  EXPECT_LT(RotationError(scene, pose), 1e-6);
  EXPECT_EQ(pose.inliers.size(), 30u);
}

TEST(RelativePose, TurningOnTheSpotHasARotation) {
  Random random(4);
  const Scene scene = MakeScene(random, 60, 20, 0.0005, 0);
  const RelativePose pose = FindRelativePose(scene.rays);
  EXPECT_TRUE(pose.accepted());
  EXPECT_LT(RotationError(scene, pose), 0.15 * kDegree);
}

TEST(RelativePose, CovarianceCoversTheErrors) {
  Random random(5);
  double sum = 0;
  constexpr int kTrials = 25;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Scene scene = MakeScene(random, 80, 20, 0.0005, 1);
    const RelativePose pose = FindRelativePose(scene.rays);
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(scene.b_from_a * pose.b_from_a.transpose()));
    const Eigen::Vector3d w = turn.angle() * turn.axis();
    sum += w.dot(pose.covariance.ldlt().solve(w)) / 3;
  }
  EXPECT_GT(sum / kTrials, 0.5);
  EXPECT_LT(sum / kTrials, 2.0);
}

// Sideways along a wall: a plane leaves two motions, of which the true one is one.
TEST(RelativePose, OfAPlaneAloneIsOneOfTwo) {
  Random random(6);
  Scene scene;
  scene.b_from_a = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()).toRotationMatrix();
  scene.translation = {-0.4, 0, 0};
  const auto see = [&](const Eigen::Vector3d& x_a) {
    scene.rays.a.push_back(x_a.normalized());
    scene.rays.b.push_back((scene.b_from_a * x_a + scene.translation).normalized());
  };
  // All of it lies on the side to which the rig moves.
  for (int i = 0; i < 200; ++i) see({random.Uniform(0.3, 1.7), random.Uniform(-0.5, 0.5), 1.2});
  const RelativePose wall = FindRelativePose(scene.rays, {});
  EXPECT_TRUE(wall.one_of_two());
  EXPECT_FALSE(wall.accepted());
  EXPECT_EQ(NameOf(wall.error), "planar");
  ASSERT_TRUE(wall.rival);
  const auto off = [&](const Eigen::Matrix3d& found) {
    return Eigen::AngleAxisd(Eigen::Matrix3d(scene.b_from_a * found.transpose())).angle();
  };
  EXPECT_LT(std::min(off(wall.b_from_a), off(wall.rival->b_from_a)), 0.002);
  EXPECT_GT(std::max(off(wall.b_from_a), off(wall.rival->b_from_a)), 0.1);
  // The floor settles it.
  for (int i = 0; i < 60; ++i) see({random.Uniform(0.3, 1.7), 0.5, random.Uniform(0.7, 1.2)});
  const RelativePose both = FindRelativePose(scene.rays, {});
  EXPECT_TRUE(both.accepted());
  EXPECT_LT(off(both.b_from_a), 0.002);
}

TEST(RelativePose, RefusesMatchesOfNothing) {
  Random random(6);
  for (const int wrong : {0, 5, 12, 100}) {
    const Scene scene = MakeScene(random, 0, wrong, 0, 1);
    EXPECT_FALSE(FindRelativePose(scene.rays).accepted()) << wrong;
  }
  const Scene few = MakeScene(random, 9, 0, 0, 1);
  EXPECT_EQ(FindRelativePose(few.rays).error, RelativeError::kFewInliers);
}

// Most of what a robot sees lies near the horizon. Rays that are spread over it alone fit a wrong
// motion far more often than rays that are spread over the sphere.
TEST(RelativePose, UnrelatedMatchesNearTheHorizonAreChance) {
  Random random(8);
  const auto near_horizon = [&] {
    const double azimuth = random.Uniform(-std::numbers::pi, std::numbers::pi);
    return Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0.02 * random.Normal())
        .normalized();
  };
  for (int trial = 0; trial < 60; ++trial) {
    MatchedRays rays;
    for (int i = 0; i < 100; ++i) {
      rays.a.push_back(near_horizon());
      rays.b.push_back(near_horizon());
    }
    const RelativePose pose = FindRelativePose(rays);
    EXPECT_FALSE(pose.accepted());
    EXPECT_GT(pose.log10_chance, -2) << trial << ": " << pose.inliers.size() << " inliers";
  }
}

TEST(RelativePose, SameSeedSamePose) {
  Random random(7);
  const Scene scene = MakeScene(random, 40, 60, 0.001, 1);
  const RelativePose one = FindRelativePose(scene.rays);
  const RelativePose two = FindRelativePose(scene.rays);
  EXPECT_EQ(one.b_from_a, two.b_from_a);
  EXPECT_EQ(one.inliers, two.inliers);
}

TEST(RelativePose, ErrorIsTheAngleARayIsOff) {
  // Straight ahead by one metre; a point at the side, one ray lifted by 1 mrad off the plane.
  const Eigen::Vector3d forward(0, 0, 1);
  const Eigen::Vector3d a = Eigen::Vector3d(1, 0, 0);
  const Eigen::Vector3d b = Eigen::Vector3d(1, 0.001, -0.1).normalized();
  EXPECT_NEAR(EpipolarError(Eigen::Matrix3d::Identity(), forward, a, b), 0.001 / std::sqrt(2.0),
              2e-5);
}

TEST(RelativeOptions, OutOfRangeIsRefused) {
  EXPECT_THROW((RelativeOptions{.max_error_rad = 0}.Check()), MapError);
  EXPECT_THROW((RelativeOptions{.min_inliers = 4}.Check()), MapError);
}

}  // namespace
}  // namespace waystone
