// SPDX-License-Identifier: Apache-2.0
#include "core/homography/transfer_jacobian.h"

namespace waystone {

TransferJacobian ApplyJacobian(const Eigen::Vector3d& mapped, const Eigen::Vector3d& x) {
  const double inverse = 1.0 / mapped.z();
  const Eigen::Vector2d y = mapped.head<2>() * inverse;
  TransferJacobian jacobian = TransferJacobian::Zero();
  jacobian.block<1, 3>(0, 0) = x.transpose() * inverse;
  jacobian.block<1, 3>(1, 3) = x.transpose() * inverse;
  jacobian.block<1, 3>(0, 6) = -y.x() * x.transpose() * inverse;
  jacobian.block<1, 3>(1, 6) = -y.y() * x.transpose() * inverse;
  return jacobian;
}

TransferJacobian InverseJacobian(const Eigen::Matrix3d& g, const Eigen::Vector3d& x) {
  const Eigen::Vector3d mapped = g * x;
  const double inverse = 1.0 / mapped.z();
  Eigen::Matrix<double, 2, 3> projection;
  projection << inverse, 0, -mapped.x() * inverse * inverse, 0, inverse,
      -mapped.y() * inverse * inverse;
  const Eigen::Matrix<double, 2, 3> left = -projection * g;
  TransferJacobian jacobian;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      jacobian.col(3 * row + column) = left.col(row) * mapped(column);
    }
  }
  return jacobian;
}

}  // namespace waystone
