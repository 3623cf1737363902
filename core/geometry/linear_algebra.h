// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace waystone {

// Decompositions of small matrices. Eigen compiles its own anew for every size in every file,
// seconds each: these are compiled once. What they allocate is small beside what their callers do.
// Pure.

struct SymmetricEigen {
  bool converged = false;
  Eigen::VectorXd values;   // ascending
  Eigen::MatrixXd vectors;  // a column each, of unit length
};

// Of a symmetric n x n matrix; only its lower half is read.
SymmetricEigen DecomposeSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a);

// The three eigenvalues of any matrix, in no particular order; NaN of one that isn't finite.
Eigen::Vector3cd ComputeEigenvalues3x3(const Eigen::Matrix3d& a);

// x of a x = b for a symmetric positive semidefinite n x n matrix and n x k right-hand sides;
// directions that `a` doesn't determine get 0.
Eigen::MatrixXd SolveSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a,
                               const Eigen::Ref<const Eigen::MatrixXd>& b);

// The inverse of a symmetric positive definite n x n matrix.
Eigen::MatrixXd InvertSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& a);

}  // namespace waystone
