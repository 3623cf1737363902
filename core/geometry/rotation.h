// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace waystone {

// Small helpers for directions and rotations in space. All are pure; thread-safe.

// The matrix [v]x with [v]x w = v x w.
Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v);

// Angle between two directions of any length, rad, in [0, pi]; exact near 0 and near pi.
double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

// exp([w]x): the rotation about w by its length, rad. The identity for w = 0.
Eigen::Matrix3d RotationByVector(const Eigen::Vector3d& w);

// Angle of the rotation between two frames' axes, rad, in [0, pi].
double RotationAngle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

// Standard deviation along the least certain direction: the root of the largest eigenvalue of a
// symmetric covariance, 0 where rounding makes that negative. The covariance is in the square of
// its unit.
double WorstAxisSigma(const Eigen::Matrix3d& covariance);

}  // namespace waystone
