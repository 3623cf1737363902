// SPDX-License-Identifier: Apache-2.0
// Rotations of space and poses of the ground as groups, as properties over generated ones.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/geometry/angle.h"
#include "core/geometry/linear_algebra.h"
#include "core/geometry/pose2.h"
#include "core/geometry/rotation.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

double DrawReal(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1'000'001) / 1e6;
}

// Turns by 0 to `most` rad, often by next to nothing.
Vector3d DrawTurn(double most) {
  const Vector3d axis =
      Quaterniond(DrawReal(-1, 1), DrawReal(-1, 1), DrawReal(-1, 1), 0.1).normalized() *
      Vector3d::UnitX();
  const double tiny = std::pow(10.0, *rc::gen::inRange(-300, 0));
  return axis.normalized() * (*rc::gen::inRange(0, 4) == 0 ? tiny : DrawReal(0, most));
}

Pose2 DrawPose() { return {DrawReal(-50, 50), DrawReal(-50, 50), DrawReal(-kPi, kPi)}; }

bool Near(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y) < 1e-9 &&
         std::abs(WrappedAngle(a.theta_rad - b.theta_rad)) < 1e-12;
}

template <class Property>
void ExpectForAll(const std::string& what, const Property& property) {
  EXPECT_TRUE(rc::check(what, property));
}

TEST(RotationProperties, TheLogarithmGivesTheVectorBack) {
  ExpectForAll("log(exp([w]x)) = w below half a turn", [] {
    const Vector3d w = DrawTurn(kPi - 1e-3);
    const Matrix3d r = RotationByVector(w);
    RC_ASSERT((r * r.transpose()).isIdentity(1e-12));
    RC_ASSERT(std::abs(r.determinant() - 1) < 1e-12);
    const Eigen::AngleAxisd log(r);
    RC_ASSERT((log.angle() * log.axis() - w).norm() < 1e-9);
    RC_ASSERT(std::abs(RotationAngle(Matrix3d::Identity(), r) - w.norm()) < 1e-6);
  });
}

TEST(RotationProperties, QuaternionsAreTheSameGroup) {
  ExpectForAll("R(q) R(r) = R(q r), R(-q) = R(q), R(q*) = R(q)^T", [] {
    const Vector3d v = DrawTurn(20);
    const Vector3d w = DrawTurn(20);
    const auto quaternion = [](const Vector3d& turn) {
      const double half = turn.norm() / 2;
      const Vector3d vector =
          half == 0 ? Vector3d(0, 0, 0) : Vector3d(std::sin(half) * turn / (2 * half));
      return Quaterniond(std::cos(half), vector.x(), vector.y(), vector.z());
    };
    const Quaterniond q = quaternion(v);
    RC_ASSERT(std::abs(q.norm() - 1) < 1e-9);
    const Matrix3d product = RotationByVector(v) * RotationByVector(w);
    RC_ASSERT((q * quaternion(w)).toRotationMatrix().isApprox(product, 1e-9));
    RC_ASSERT(Quaterniond(-q.coeffs()).toRotationMatrix().isApprox(RotationByVector(v), 1e-9));
    RC_ASSERT(RotationByVector(-v).isApprox(RotationByVector(v).transpose(), 1e-9));
    RC_ASSERT(RotationAngle(RotationByVector(v), product) <= kPi);
  });
}

TEST(RotationProperties, PosesOfTheGroundAreAGroup) {
  ExpectForAll("(p q) r = p (q r), p p^-1 = 1, angles stay wrapped", [] {
    const Pose2 p = DrawPose();
    const Pose2 q = DrawPose();
    const Pose2 r = DrawPose();
    RC_ASSERT(Near((p * q) * r, p * (q * r)));
    RC_ASSERT(Near(p * Inverse(p), Pose2{}));
    RC_ASSERT(Near(Inverse(p * q), Inverse(q) * Inverse(p)));
    RC_ASSERT(std::abs((p * q).theta_rad) <= kPi);
  });
}

// NaN may come of NaN alone; nothing hangs and nothing is made up.
TEST(RotationProperties, DegenerateInput) {
  ExpectForAll("finite for any finite turn", [] {
    const double size = std::pow(10.0, *rc::gen::inRange(-320, 150));
    const Vector3d w = size * Vector3d(DrawReal(-1, 1), DrawReal(-1, 1), DrawReal(-1, 1));
    const Matrix3d r = RotationByVector(w);
    RC_ASSERT(r.allFinite());
    RC_ASSERT((r * r.transpose()).isIdentity(1e-9));
    RC_ASSERT(std::isfinite(AngleBetween(w, Vector3d::UnitX())));
  });
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(RotationByVector({nan, 0, 0}).allFinite());
  EXPECT_EQ(AngleBetween(Vector3d::Zero(), Vector3d::UnitX()), 0);
}

TEST(RotationProperties, EigenvaluesOfAnyMatrix) {
  ExpectForAll("sum and product are trace and determinant", [] {
    Matrix3d a;
    for (int k = 0; k < 9; ++k) a(k / 3, k % 3) = *rc::gen::inRange(-3, 4);
    const Eigen::Vector3cd values = ComputeEigenvalues3x3(a);
    RC_ASSERT(values.allFinite());
    RC_ASSERT(std::abs(values.sum() - a.trace()) < 1e-6);
    RC_ASSERT(std::abs(values.prod() - a.determinant()) < 1e-6);
  });
}

}  // namespace
}  // namespace waystone
