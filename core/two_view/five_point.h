// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace waystone {

// The essential matrices (at most 10, of unit norm) of five matched rays in any direction,
// x_b^T E x_a = 0, by the eigenvectors of an action matrix (Stewenius, Engels and Nister, "Recent
// developments on direct relative orientation", 2006). OpenCV's solver takes points on an image
// plane and sometimes misses a root. Deterministic; thread-safe.
std::vector<Eigen::Matrix3d> SolveFivePoints(const std::array<Eigen::Vector3d, 5>& a,
                                             const std::array<Eigen::Vector3d, 5>& b);

// The four motions x_b = R x_a + t of an essential matrix, |t| = 1. Thread-safe.
struct Motion {
  Eigen::Matrix3d b_from_a;
  Eigen::Vector3d translation;
};
std::array<Motion, 4> DecomposeEssential(const Eigen::Matrix3d& essential);

}  // namespace waystone
