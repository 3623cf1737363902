// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

#include "bench/baseline/paper_directions.h"
#include "bench/baseline/paper_motion.h"
#include "core/base/random.h"
#include "core/geometry/rotation.h"
#include "core/manhattan/cube_rotations.h"

namespace waystone::bench {
namespace {

Eigen::Vector3d DrawDirection(Random& random) {
  return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
}

Eigen::Matrix3d DrawRotation(Random& random) {
  return Eigen::AngleAxisd(random.Uniform(0, 3), DrawDirection(random)).toRotationMatrix();
}

TEST(PaperDirections, AreThoseThatMostLinesVoteFor) {
  Random random(4);
  const Eigen::Matrix3d rig_from_axes = DrawRotation(random);
  std::vector<GreatCircle> lines;
  for (int i = 0; i < 120; ++i) {
    const Eigen::Vector3d axis = i < 90 ? rig_from_axes.col(i % 3) : DrawDirection(random);
    GreatCircle line;
    line.normal = (axis.cross(DrawDirection(random)).normalized() + 0.002 * DrawDirection(random))
                      .normalized();
    line.middle = line.normal.unitOrthogonal();
    line.along = line.middle.cross(line.normal);
    line.length_rad = 0.2;
    line.segment.a.setZero();
    line.segment.b.setZero();
    lines.push_back(line);
  }
  const auto found = FindDirectionsByVotes(lines);
  ASSERT_TRUE(found);
  EXPECT_NEAR((found->transpose() * *found - Eigen::Matrix3d::Identity()).norm(), 0, 1e-9);
  EXPECT_LT(WorstAxisAngle(*found, rig_from_axes), 0.03);
  EXPECT_FALSE(FindDirectionsByVotes(std::vector(lines.begin(), lines.begin() + 2)));
}

TEST(PaperMotion, EightPointsFindTheMotionAmongWrongMatches) {
  Random random(5);
  const Eigen::Matrix3d b_from_a = RotationByVector(0.3 * DrawDirection(random));
  const Eigen::Vector3d translation = DrawDirection(random);
  MatchedRays rays;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d x = random.Uniform(3, 8) * DrawDirection(random);
    rays.a.push_back((x.normalized() + 2e-4 * DrawDirection(random)).normalized());
    rays.b.push_back(i % 5 == 0 ? DrawDirection(random)
                                : Eigen::Vector3d((b_from_a * x + translation).normalized()));
  }
  const auto found = FindMotionByEightPoints(rays);
  ASSERT_TRUE(found);
  EXPECT_GE(found->inliers.size(), 150U);
  EXPECT_LT(RotationAngle(found->motion.b_from_a, b_from_a), 0.005);
  EXPECT_GT(found->motion.translation.dot(translation), 0.99);
  rays.a.resize(7);
  rays.b.resize(7);
  EXPECT_FALSE(FindMotionByEightPoints(rays));
}

}  // namespace
}  // namespace waystone::bench
