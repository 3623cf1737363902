// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/five_point.h"

#include <Eigen/Dense>

namespace waystone {
namespace {

using Rays = std::array<Eigen::Vector3d, 5>;

// Polynomials in the unknowns x, y, z of E = x E1 + y E2 + z E3 + E4, by the coefficients of their
// monomials. Of degree 1: x, y, z, 1. Of degree 2: x^2, xy, xz, y^2, yz, z^2, then those of
// degree 1. Of degree 3: x^3, x^2 y, x^2 z, x y^2, xyz, x z^2, y^3, y^2 z, y z^2, z^3, then those
// of degree 2.
using Linear = Eigen::Matrix<double, 1, 4>;
using Quadratic = Eigen::Matrix<double, 1, 10>;
using Cubic = Eigen::Matrix<double, 1, 20>;
using Matrix10d = Eigen::Matrix<double, 10, 10>;

// The monomial of degree 2 that is the product of two of degree 1.
constexpr int kSquare[4][4] = {{0, 1, 2, 6}, {1, 3, 4, 7}, {2, 4, 5, 8}, {6, 7, 8, 9}};
// The monomial of degree 3 that is the product of one of degree 2 and one of degree 1.
constexpr int kCube[10][4] = {{0, 1, 2, 10},    {1, 3, 4, 11},   {2, 4, 5, 12},    {3, 6, 7, 13},
                              {4, 7, 8, 14},    {5, 8, 9, 15},   {10, 11, 12, 16}, {11, 13, 14, 17},
                              {12, 14, 15, 18}, {16, 17, 18, 19}};

Quadratic operator*(const Linear& a, const Linear& b) {
  Quadratic product = Quadratic::Zero();
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) product(kSquare[i][j]) += a(i) * b(j);
  }
  return product;
}

Cubic operator*(const Quadratic& a, const Linear& b) {
  Cubic product = Cubic::Zero();
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 4; ++j) product(kCube[i][j]) += a(i) * b(j);
  }
  return product;
}

// E1 to E4 as columns, row by row: they span the matrices with x_b^T E x_a = 0 for all five
// matches.
Eigen::Matrix<double, 9, 4> NullSpace(const Rays& a, const Rays& b) {
  Eigen::Matrix<double, 9, 5> equations;
  for (int i = 0; i < 5; ++i) {
    for (int row = 0; row < 3; ++row) equations.col(i).segment<3>(3 * row) = b[i](row) * a[i];
  }
  const Eigen::HouseholderQR<Eigen::Matrix<double, 9, 5>> qr(equations);
  return qr.householderQ() *
         Eigen::Matrix<double, 9, 4>(Eigen::Matrix<double, 9, 9>::Identity().rightCols<4>());
}

// The constraints of an essential matrix, E E^T E - 1/2 trace(E E^T) E = 0 and det E = 0, as ten
// equations.
Eigen::Matrix<double, 10, 20> EssentialConstraints(const Eigen::Matrix<double, 9, 4>& basis) {
  const auto e = [&](int row, int column) -> Linear { return basis.row(3 * row + column); };
  Quadratic square[3][3];  // E E^T
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      square[i][j] = square[j][i] = e(i, 0) * e(j, 0) + e(i, 1) * e(j, 1) + e(i, 2) * e(j, 2);
    }
  }
  const Quadratic half_trace = (square[0][0] + square[1][1] + square[2][2]) / 2;
  for (int i = 0; i < 3; ++i) square[i][i] -= half_trace;
  Eigen::Matrix<double, 10, 20> constraints;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      constraints.row(3 * i + j) =
          square[i][0] * e(0, j) + square[i][1] * e(1, j) + square[i][2] * e(2, j);
    }
  }
  // Of the first two rows; the determinant is its product with the third.
  const auto cross = [&](int j, int k) -> Quadratic {
    return e(0, j) * e(1, k) - e(0, k) * e(1, j);
  };
  constraints.row(9) = cross(1, 2) * e(2, 0) + cross(2, 0) * e(2, 1) + cross(0, 1) * e(2, 2);
  return constraints;
}

}  // namespace

std::vector<Eigen::Matrix3d> SolveFivePoints(const Rays& a, const Rays& b) {
  const Eigen::Matrix<double, 9, 4> basis = NullSpace(a, b);
  const Eigen::Matrix<double, 10, 20> constraints = EssentialConstraints(basis);
  // Each monomial of degree 3 as a combination of the ten of lower degree.
  const Matrix10d reduced =
      -constraints.leftCols<10>().partialPivLu().solve(constraints.rightCols<10>());
  std::vector<Eigen::Matrix3d> solutions;
  if (!reduced.allFinite()) return solutions;
  // Multiplication by x of the monomials of lower degree. At a solution their values are an
  // eigenvector.
  Matrix10d times_x;
  for (int i = 0; i < 10; ++i) {
    const int product = kCube[i][0];
    if (product < 10) {
      times_x.row(i) = reduced.row(product);
    } else {
      times_x.row(i) = Matrix10d::Identity().row(product - 10);
    }
  }
  const Eigen::EigenSolver<Matrix10d> eigen(times_x);
  if (eigen.info() != Eigen::Success) return solutions;
  const Matrix10d& vectors = eigen.pseudoEigenvectors();
  for (int i = 0; i < 10; ++i) {
    if (eigen.eigenvalues()(i).imag() != 0) continue;
    const Eigen::Matrix<double, 9, 1> e = (basis * vectors.col(i).tail<4>()).normalized();
    if (e.allFinite()) {
      solutions.emplace_back(Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(e.data()));
    }
  }
  return solutions;
}

std::array<Motion, 4> DecomposeEssential(const Eigen::Matrix3d& essential) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  Eigen::Matrix3d v = svd.matrixV();
  if (u.determinant() < 0) u = -u;
  if (v.determinant() < 0) v = -v;
  Eigen::Matrix3d w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d one = u * w * v.transpose();
  const Eigen::Matrix3d other = u * w.transpose() * v.transpose();
  const Eigen::Vector3d t = u.col(2);
  return {{{one, t}, {one, -t}, {other, t}, {other, -t}}};
}

}  // namespace waystone
