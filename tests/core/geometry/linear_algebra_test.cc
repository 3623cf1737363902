// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/linear_algebra.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "core/base/random.h"

namespace waystone {
namespace {

Eigen::MatrixXd RandomMatrix(int rows, int columns, Random& random) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.Normal(); });
}

// Symmetric and positive definite.
Eigen::MatrixXd RandomInformation(int n, Random& random) {
  const Eigen::MatrixXd rows = RandomMatrix(2 * n, n, random);
  return rows.transpose() * rows;
}

TEST(LinearAlgebra, EigenvectorsAreScaledByTheirAscendingValues) {
  Random random(1);
  for (const int n : {1, 2, 3, 8, 9}) {
    const Eigen::MatrixXd a = RandomInformation(n, random);
    const SymmetricEigen eigen = DecomposeSymmetric(a);
    ASSERT_TRUE(eigen.converged);
    EXPECT_TRUE(std::ranges::is_sorted(eigen.values));
    EXPECT_TRUE((a * eigen.vectors).isApprox(eigen.vectors * eigen.values.asDiagonal(), 1e-9)) << n;
    EXPECT_TRUE((eigen.vectors.transpose() * eigen.vectors).isIdentity(1e-9)) << n;
  }
}

TEST(LinearAlgebra, OnlyTheLowerHalfIsRead) {
  Random random(2);
  const Eigen::MatrixXd a = RandomInformation(4, random);
  Eigen::MatrixXd lower = a;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(7);
  EXPECT_EQ(DecomposeSymmetric(lower).values, DecomposeSymmetric(a).values);
}

TEST(LinearAlgebra, EigenvaluesMayBeComplex) {
  Eigen::Matrix3d a;
  a << 0, -2, 0, 2, 0, 0, 0, 0, 5;  // a turn by 90 degrees, twice as long
  const Eigen::Vector3cd values = ComputeEigenvalues3x3(a);
  for (const std::complex<double> expected : {std::complex(0.0, 2.0), {0.0, -2.0}, {5.0, 0.0}}) {
    EXPECT_TRUE(std::ranges::any_of(values, [&](const auto& value) {
      return std::abs(value - expected) < 1e-12;
    })) << expected;
  }
}

TEST(LinearAlgebra, SolutionsAndInversesSolve) {
  Random random(3);
  for (const int n : {1, 2, 5, 8, 10}) {
    const Eigen::MatrixXd a = RandomInformation(n, random);
    const Eigen::MatrixXd b = RandomMatrix(n, 2, random);
    EXPECT_TRUE((a * SolveSymmetric(a, b)).isApprox(b, 1e-9)) << n;
    EXPECT_TRUE((a * InvertSymmetric(a)).isIdentity(1e-9)) << n;
  }
}

TEST(LinearAlgebra, WhatIsNotDeterminedIsZero) {
  const Eigen::Matrix2d flat = Eigen::Vector2d(4, 0).asDiagonal();
  EXPECT_EQ(SolveSymmetric(flat, Eigen::Vector2d(8, 0)), Eigen::Vector2d(2, 0));
  EXPECT_EQ(SolveSymmetric(Eigen::Matrix2d::Zero(), Eigen::Vector2d(1, 1)),
            Eigen::Vector2d::Zero());
}

TEST(LinearAlgebra, WhatIsNotFiniteHasNoEigenvalues) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Identity();
    a(0, 1) = bad;
    EXPECT_TRUE(std::isnan(ComputeEigenvalues3x3(a)[0].real())) << bad;
  }
}

}  // namespace
}  // namespace waystone
