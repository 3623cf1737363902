// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/geometry/angle.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d RandomVector(Random& random) {
  return {random.Normal(), random.Normal(), random.Normal()};
}

TEST(Rotation, CrossMatrixIsTheCrossProduct) {
  Random random(1);
  const Vector3d v = RandomVector(random);
  const Vector3d w = RandomVector(random);
  EXPECT_TRUE((CrossMatrix(v) * w).isApprox(v.cross(w), 1e-12));
}

TEST(Rotation, AngleBetweenIsExactNearItsEnds) {
  const Vector3d x = 3 * Vector3d::UnitX();
  EXPECT_NEAR(AngleBetween(x, {1, 1e-9, 0}), 1e-9, 1e-15);
  EXPECT_NEAR(AngleBetween(x, {-1, 1e-9, 0}), kPi - 1e-9, 1e-12);
  EXPECT_NEAR(AngleBetween(x, {0, 0, 5}), kQuarterTurn_rad, 1e-12);
}

TEST(Rotation, ByVectorTurnsAboutItByItsLength) {
  EXPECT_EQ(RotationByVector(Vector3d::Zero()), Matrix3d::Identity());
  const Matrix3d quarter = RotationByVector({0, 0, kQuarterTurn_rad});
  EXPECT_TRUE((quarter * Vector3d::UnitX()).isApprox(Vector3d::UnitY(), 1e-12));
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Vector3d w = RandomVector(random);
    const Matrix3d r = RotationByVector(w);
    EXPECT_TRUE((r * r.transpose()).isIdentity(1e-12));
    EXPECT_NEAR(r.determinant(), 1, 1e-12);
    EXPECT_TRUE((r * w).isApprox(w, 1e-12));
    EXPECT_TRUE(RotationByVector(-w).isApprox(r.transpose(), 1e-12));
  }
}

// d exp([w]x) x / dw at 0 is -[x]x, which the refinements use.
TEST(Rotation, ByVectorHasTheDerivativeThatRefinementsUse) {
  Random random(3);
  constexpr double kStep = 1e-6;
  const Vector3d x = RandomVector(random);
  Matrix3d measured;
  for (int k = 0; k < 3; ++k) {
    const Vector3d step = kStep * Vector3d::Unit(k);
    measured.col(k) = (RotationByVector(step) * x - RotationByVector(-step) * x) / (2 * kStep);
  }
  EXPECT_TRUE(measured.isApprox(-CrossMatrix(x), 1e-8));
}

TEST(Rotation, WorstAxisSigmaIsTheLargestOne) {
  const Matrix3d axes = RotationByVector({0.3, -0.2, 0.7});
  const Matrix3d covariance = axes * Vector3d(4, 1, 9).asDiagonal() * axes.transpose();
  EXPECT_NEAR(WorstAxisSigma(covariance), 3, 1e-12);
  EXPECT_EQ(WorstAxisSigma(Matrix3d::Zero()), 0);
  EXPECT_EQ(WorstAxisSigma(-1e-20 * Matrix3d::Identity()), 0) << "rounding";
  EXPECT_EQ(WorstAxisSigma(Matrix3d::Constant(std::nan(""))),
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace waystone
