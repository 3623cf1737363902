// SPDX-License-Identifier: Apache-2.0
#include "core/camera_pose/absolute_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/rotation.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kSigma_rad = 0.0015;

Vector3d Noise(Random& random) { return {random.Normal(), random.Normal(), random.Normal()}; }

Isometry3d RandomPose(Random& random) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = 2 * Noise(random);
  pose.linear() = RotationByVector(Noise(random));
  return pose;
}

// Points 1 to 5 ahead of a camera, known with a sigma along the ray of a camera beside it; the
// first `outliers` are seen elsewhere.
std::vector<PointSighting> MakeScene(const Isometry3d& pose, int points, int outliers,
                                     double relative_sigma, Random& random) {
  std::vector<PointSighting> scene;
  for (int i = 0; i < points; ++i) {
    const Vector3d ray(random.Uniform(-0.5, 0.5), random.Uniform(-0.4, 0.4), 1);
    const double depth = random.Uniform(1, 5);
    PointSighting sighting;
    const Vector3d truth = pose * (depth * ray);
    const Vector3d beside = pose.translation() + 0.5 * Noise(random).normalized();
    sighting.along = relative_sigma * (truth - beside);
    sighting.point = truth + random.Normal() * sighting.along;
    sighting.sigma_rad = kSigma_rad;
    const Vector3d seen = i < outliers ? Vector3d(random.Uniform(-0.5, 0.5), 0.3, 1) : ray;
    sighting.ray = (seen.normalized() + kSigma_rad * Noise(random)).normalized();
    scene.push_back(sighting);
  }
  return scene;
}

TEST(FindAbsolutePose, StatesItsErrors) {
  Random random(1);
  double nees = 0;
  int found = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Isometry3d truth = RandomPose(random);
    const auto pose = FindAbsolutePose(MakeScene(truth, 60, 15, 0.02, random), {});
    if (!pose) continue;
    ++found;
    Eigen::Matrix<double, 6, 1> error;
    error.head<3>() = truth.translation() - pose->world_from_camera.translation();
    const Eigen::AngleAxisd turn(truth.linear() * pose->world_from_camera.linear().transpose());
    error.tail<3>() = turn.angle() * turn.axis();
    EXPECT_LT(error.head<3>().norm(), 0.05);
    EXPECT_LT(error.tail<3>().norm(), 0.01);
    EXPECT_GE(pose->inliers.size(), 40u);
    EXPECT_GE(pose->inliers.front(), 0);
    nees += error.dot(pose->covariance.ldlt().solve(error)) / 6 / kTrials;
  }
  EXPECT_GE(found, kTrials - 2);
  EXPECT_GT(nees, 0.7);
  EXPECT_LT(nees, 1.5);
}

// Near the points their uncertainty covers the whole image: a pose there explains any match, and
// the more samples are drawn, the likelier is one that gives it.
TEST(FindAbsolutePose, ManySamplesDoNotLeadToThePoints) {
  Random random(1);
  int found = 0;
  constexpr int kTrials = 100;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Isometry3d truth = RandomPose(random);
    const auto pose =
        FindAbsolutePose(MakeScene(truth, 60, 15, 0.02, random), {.confidence = 1 - 1e-12});
    found += pose && (pose->world_from_camera.translation() - truth.translation()).norm() < 0.05;
  }
  EXPECT_EQ(found, kTrials);
}

TEST(FindAbsolutePose, FindsNothingInChance) {
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Isometry3d truth = RandomPose(random);
    std::vector<PointSighting> scene = MakeScene(truth, 30, 0, 0, random);
    std::vector<Vector3d> rays;
    for (const PointSighting& sighting : scene) rays.push_back(sighting.ray);
    std::rotate(rays.begin(), rays.begin() + 7, rays.end());
    for (size_t i = 0; i < rays.size(); ++i) scene[i].ray = rays[i];
    EXPECT_FALSE(FindAbsolutePose(scene, {}));
  }
}

TEST(FindAbsolutePose, WantsEnoughMatchesOfDistinctFeatures) {
  Random random(3);
  const Isometry3d truth = RandomPose(random);
  EXPECT_FALSE(FindAbsolutePose({}, {}));
  EXPECT_FALSE(FindAbsolutePose(MakeScene(truth, 7, 0, 0, random), {}));
  std::vector<PointSighting> scene = MakeScene(truth, 12, 0, 0, random);
  EXPECT_TRUE(FindAbsolutePose(scene, {}));
  for (PointSighting& sighting : scene) sighting.weight = 0.5;  // two of each feature
  EXPECT_FALSE(FindAbsolutePose(scene, {}));
}

TEST(FindAbsolutePose, IsTheSameAgain) {
  Random random(4);
  const std::vector<PointSighting> scene = MakeScene(RandomPose(random), 40, 10, 0.01, random);
  const auto a = FindAbsolutePose(scene, {});
  const auto b = FindAbsolutePose(scene, {});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->world_from_camera.matrix(), b->world_from_camera.matrix());
  EXPECT_EQ(a->covariance, b->covariance);
}

TEST(RefineAbsolutePose, StartsFromAPose) {
  Random random(5);
  const Isometry3d truth = RandomPose(random);
  const std::vector<PointSighting> scene = MakeScene(truth, 60, 0, 0.01, random);
  Isometry3d start = truth;
  start.translation() += Vector3d(0.005, -0.005, 0.005);
  const auto pose = RefineAbsolutePose(scene, start, {});
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->world_from_camera.translation() - truth.translation()).norm(), 0.01);
}

}  // namespace
}  // namespace waystone
