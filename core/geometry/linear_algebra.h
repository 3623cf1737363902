// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace waystone {

// Decompositions of small matrices. Eigen's templates are compiled anew for every size in every
// file, which takes seconds each; these are compiled once. Their allocations cost little beside the
// callers' work. All are pure; thread-safe.

struct SymmetricEigen {
  bool converged = false;
  Eigen::VectorXd values;   // ascending
  Eigen::MatrixXd vectors;  // one per column, of unit length
};

// Of a symmetric n x n matrix; only its lower half is read.
SymmetricEigen DecomposeSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a);

// The three eigenvalues of any matrix, in no particular order; NaN for one that isn't finite.
Eigen::Vector3cd ComputeEigenvalues3x3(const Eigen::Matrix3d& a);

// x of a x = b for a symmetric positive semidefinite n x n matrix and n x k right-hand sides;
// directions that `a` doesn't determine get 0.
Eigen::MatrixXd SolveSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a,
                               const Eigen::Ref<const Eigen::MatrixXd>& b);

// The inverse of a symmetric positive definite n x n matrix.
Eigen::MatrixXd InvertSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a);

}  // namespace waystone
