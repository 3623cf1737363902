// SPDX-License-Identifier: Apache-2.0
// Derivatives against finite differences.
#include <gtest/gtest.h>

#include "core/geometry/rotation.h"
#include "core/homography/space_fit.h"
#include "core/homography/transfer_jacobian.h"
#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Homographies whose entries have one size: points are within one unit of the origin.
Matrix3d TameHomography(Random& random) {
  Matrix3d h = Matrix3d::Identity();
  for (int k = 0; k < 8; ++k) h(k / 3, k % 3) += random.Uniform(-0.2, 0.2);
  return h;
}

template <class Move>
TransferJacobian Differences(const Move& moved_by) {
  constexpr double kStep = 1e-6;
  TransferJacobian differences;
  for (int k = 0; k < 9; ++k) {
    differences.col(k) = (moved_by(k, kStep) - moved_by(k, -kStep)) / (2 * kStep);
  }
  return differences;
}

TEST(Jacobians, OfATransferAndOfItsInverse) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix3d h = TameHomography(random);
    const Vector2d x(random.Uniform(-1, 1), random.Uniform(-1, 1));
    const auto stepped = [&](int k, double step) {
      Matrix3d moved = h;
      moved(k / 3, k % 3) += step;
      return moved;
    };
    const Vector3d mapped = h * x.homogeneous();
    EXPECT_TRUE(
        ApplyJacobian(mapped, x.homogeneous())
            .isApprox(Differences([&](int k, double s) { return Apply(stepped(k, s), x); }), 1e-6));
    EXPECT_TRUE(InverseJacobian(h.inverse(), x.homogeneous())
                    .isApprox(Differences([&](int k, double s) {
                                return Apply(stepped(k, s).inverse(), x);
                              }),
                              1e-6));
  }
}

TEST(Jacobians, OfPlanesAndMotionsInSpace) {
  Random random(2);
  constexpr double kSigma = 0.01;
  for (int trial = 0; trial < 20; ++trial) {
    const MadeViews views = RandomViews(random);
    const MadePlane plane = RandomPlane(random);
    const Vector3d m = plane.n / plane.d;
    const Vector2d a(random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3));
    const auto error = [&](int k, double step) -> Vector2d {
      Eigen::Matrix<double, 9, 1> s = Eigen::Matrix<double, 9, 1>::Zero();
      s(k) = step;
      const Vector3d x = a.homogeneous();
      const Vector3d y = RotationByVector(s.segment<3>(3)) * views.r * x +
                         (views.t + s.tail<3>()) * (m + s.head<3>()).dot(x);
      return y.hnormalized() / kSigma;
    };
    EXPECT_TRUE(SpaceJacobian({views.r, views.t}, m, a, kSigma).isApprox(Differences(error), 1e-6));
  }
}

}  // namespace
}  // namespace waystone
