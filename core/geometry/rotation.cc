// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/rotation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace waystone {

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Eigen::Matrix3d RotationByVector(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

double RotationAngle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  // |R_a - R_b|^2 = 8 sin^2(angle / 2): exact near 0, where the trace isn't.
  return 2 * std::asin(std::clamp((a - b).norm() / std::sqrt(8.0), 0.0, 1.0));
}

double WorstAxisSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  const double variance = solver.eigenvalues()(2);
  if (std::isnan(variance)) return std::numeric_limits<double>::infinity();
  return std::sqrt(std::max(0.0, variance));
}

}  // namespace waystone
