// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/cube_rotations.h"
#include "core/geometry/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace waystone {
namespace {

Eigen::Matrix3d Turn(double angle_rad, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
}

TEST(CubeRotations, AreTwentyFourDifferentRotations) {
  const auto& all = CubeRotations();
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].determinant(), 1);
    EXPECT_TRUE((all[i].transpose() * all[i]).isIdentity());
    for (size_t j = 0; j < i; ++j) EXPECT_FALSE(all[i].isApprox(all[j]));
  }
  EXPECT_TRUE(all[0].isIdentity());
}

TEST(CubeRotations, NearestUndoesAnyRenumbering) {
  const Eigen::Matrix3d previous = Turn(1.1, {0.3, -1, 0.4});
  const Eigen::Matrix3d now = Turn(0.3, {1, 1, -0.2}) * previous;
  for (const Eigen::Matrix3d& c : CubeRotations()) {
    EXPECT_TRUE(NearestOfCube(now * c, previous).isApprox(now, 1e-12));
    EXPECT_NEAR(CubeAngle(now * c, previous), 0.3, 1e-9);
  }
}

TEST(CubeRotations, AnglesAreExactNearZero) {
  const Eigen::Matrix3d a = Turn(0.7, {1, 2, 3});
  EXPECT_NEAR(RotationAngle(Turn(1e-7, {0, 1, 1}) * a, a), 1e-7, 1e-12);
  EXPECT_NEAR(RotationAngle(Turn(3.0, {0, 1, 1}) * a, a), 3.0, 1e-9);
}

TEST(CubeRotations, WorstAxisOfATurnAboutOneAxis) {
  const Eigen::Matrix3d a = Turn(0.7, {1, 2, 3});
  const Eigen::Matrix3d b = a * Turn(0.02, {0, 0, 1}) * CubeRotations()[7];
  EXPECT_NEAR(WorstAxisAngle(a, b), 0.02, 1e-9);
}

}  // namespace
}  // namespace waystone
