// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <limits>

namespace waystone {

SymmetricEigen DecomposeSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.info() == Eigen::Success, solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::Vector3cd ComputeEigenvalues3x3(const Eigen::Matrix3d& a) {
  // The solver doesn't report values that aren't finite.
  if (a.allFinite()) {
    const Eigen::EigenSolver<Eigen::Matrix3d> solver(a, false);
    if (solver.info() == Eigen::Success) return solver.eigenvalues();
  }
  return Eigen::Vector3cd::Constant(std::numeric_limits<double>::quiet_NaN());
}

Eigen::MatrixXd SolveSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a,
                               const Eigen::Ref<const Eigen::MatrixXd>& b) {
  return Eigen::LDLT<Eigen::MatrixXd>(a).solve(b);
}

Eigen::MatrixXd InvertSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a) {
  return SolveSymmetric(a, Eigen::MatrixXd::Identity(a.rows(), a.cols()));
}

}  // namespace waystone
