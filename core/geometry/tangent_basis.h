// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace waystone {

using Basis3x2 = Eigen::Matrix<double, 3, 2>;

// Two orthogonal unit vectors perpendicular to a unit direction. Pure; thread-safe.
inline Basis3x2 TangentBasis(const Eigen::Vector3d& t) {
  Basis3x2 basis;
  basis.col(0) = t.unitOrthogonal();
  basis.col(1) = t.cross(basis.col(0));
  return basis;
}

}  // namespace waystone
