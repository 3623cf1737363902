// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/epipolar.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace waystone {
namespace {

using Eigen::Vector3d;

Vector3d DrawDirection(Random& random) {
  return Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
}

// Where the error is 0 the kept divisor makes no difference.
TEST(LineariseEpipolar, HasTheDerivativesOfFiniteDifferences) {
  Random random(1);
  for (int trial = 0; trial < 30; ++trial) {
    const Motion motion{RotationByVector(0.4 * DrawDirection(random)), DrawDirection(random)};
    const Vector3d point = 5 * DrawDirection(random);
    const Vector3d a = point.normalized();
    const Vector3d b = (motion.b_from_a * point + motion.translation).normalized();
    const Basis3x2 basis = TangentBasis(motion.translation);
    const auto error = [&](int k, double step) {
      Vector5d s = Vector5d::Zero();
      s(k) = step;
      const Motion moved{RotationByVector(s.head<3>()) * motion.b_from_a,
                         motion.translation + basis * s.tail<2>()};
      return LineariseEpipolar(moved, EssentialMatrix(moved), basis, a, b).error;
    };
    constexpr double kStep = 1e-6;
    Vector5d differences;
    for (int k = 0; k < 5; ++k) differences(k) = (error(k, kStep) - error(k, -kStep)) / (2 * kStep);
    const auto linear = LineariseEpipolar(motion, EssentialMatrix(motion), basis, a, b);
    EXPECT_NEAR(linear.error, 0, 1e-12);
    EXPECT_LT((linear.jacobian - differences).norm(), 1e-6 * (1 + differences.norm()));
  }
}

TEST(TangentBasis, IsAcrossTheDirection) {
  Random random(2);
  const Vector3d t = DrawDirection(random);
  const Basis3x2 basis = TangentBasis(t);
  EXPECT_LT((basis.transpose() * t).norm(), 1e-12);
  EXPECT_TRUE((basis.transpose() * basis).isIdentity(1e-12));
}

TEST(EpipolarErrorOfAMatrix, IsTheLinearisedOneWithoutItsSign) {
  Random random(3);
  const Motion motion{RotationByVector(DrawDirection(random)), DrawDirection(random)};
  const Eigen::Matrix3d e = EssentialMatrix(motion);
  const Vector3d a = DrawDirection(random);
  const Vector3d b = DrawDirection(random);
  const auto linear = LineariseEpipolar(motion, e, TangentBasis(motion.translation), a, b);
  EXPECT_EQ(EpipolarError(e, a, b), std::abs(linear.error));
}

}  // namespace
}  // namespace waystone
