// SPDX-License-Identifier: Apache-2.0
#include "core/base/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace waystone {

SymmetricEigen EigenOfSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.info() == Eigen::Success, solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::Vector3cd EigenvaluesOf3x3(const Eigen::Matrix3d& a) {
  return Eigen::EigenSolver<Eigen::Matrix3d>(a, false).eigenvalues();
}

Eigen::MatrixXd SolveSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a,
                               const Eigen::Ref<const Eigen::MatrixXd>& b) {
  return Eigen::LDLT<Eigen::MatrixXd>(a).solve(b);
}

Eigen::MatrixXd InverseOfSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a) {
  return SolveSymmetric(a, Eigen::MatrixXd::Identity(a.rows(), a.cols()));
}

}  // namespace waystone
