// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

// Derivatives of a transfer by the homography's nine entries, row by row: inside core/homography
// and its tests only. Pure; thread-safe.
namespace waystone {

using TransferJacobian = Eigen::Matrix<double, 2, 9>;

// Of (h x).hnormalized(), given mapped = h x.
TransferJacobian ApplyJacobian(const Eigen::Vector3d& mapped, const Eigen::Vector3d& x);

// Of (g x).hnormalized() by the entries of h, where g = h^-1: dg = -g dh g.
TransferJacobian InverseJacobian(const Eigen::Matrix3d& g, const Eigen::Vector3d& x);

}  // namespace waystone
