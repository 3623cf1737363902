// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry/rotation.h"
#include "core/geometry/tangent_basis.h"
#include "core/two_view/five_point.h"

// The epipolar error and its derivatives: inside core/two_view and its tests only. Inline, since it
// scores samples. Pure; thread-safe.
namespace waystone {

using Vector5d = Eigen::Matrix<double, 5, 1>;

inline constexpr double kLeastScale = 1e-12;  // of an error's divisor

inline Eigen::Matrix3d EssentialMatrix(const Motion& motion) {
  return CrossMatrix(motion.translation) * motion.b_from_a;
}

// |x_b^T E x_a| over its rate of change when the rays move: the length of E x_a and E^T x_b
// together.
inline double EpipolarError(const Eigen::Matrix3d& e, const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b) {
  const Eigen::Vector3d ea = e * a;
  const Eigen::Vector3d eb = e.transpose() * b;
  const double scale = std::sqrt(ea.squaredNorm() + eb.squaredNorm());
  return std::abs(b.dot(ea)) / std::max(scale, kLeastScale);
}

// The signed error, and its derivatives by a step (w, s) that takes R to exp(w) R and t to
// t + basis s. With n = x_b^T [t]x R x_a: dn/dw = R x_a x (x_b x t), dn/dt = R x_a x x_b; the
// divisor is kept, which is exact where the error is 0.
struct LinearEpipolarError {
  double error = 0;
  Vector5d jacobian;
};
inline LinearEpipolarError LineariseEpipolar(const Motion& motion, const Eigen::Matrix3d& e,
                                             const Basis3x2& basis, const Eigen::Vector3d& a,
                                             const Eigen::Vector3d& b) {
  const Eigen::Vector3d ra = motion.b_from_a * a;
  const Eigen::Vector3d ea = e * a;
  const double scale =
      std::max(std::sqrt(ea.squaredNorm() + (e.transpose() * b).squaredNorm()), kLeastScale);
  LinearEpipolarError linear{b.dot(ea) / scale, {}};
  linear.jacobian << ra.cross(b.cross(motion.translation)), basis.transpose() * ra.cross(b);
  linear.jacobian /= scale;
  return linear;
}

}  // namespace waystone
