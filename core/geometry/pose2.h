// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

namespace waystone {

// A pose on the ground: x_a = R(theta) x_b + (x, y) for a Pose2 named a_from_b, which is also the
// pose of b in a's frame. The angle is counter-clockwise from the x axis; metres unless stated
// otherwise, radians. All functions are pure; thread-safe.
struct Pose2 {
  double x = 0;
  double y = 0;
  double theta_rad = 0;

  bool operator==(const Pose2&) const = default;
};

// The distance between the positions of two poses.
inline double Apart(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

// The same angle between -pi and pi.
inline double WrappedAngle(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

// a_from_c = a_from_b * b_from_c; its angle is wrapped.
inline Pose2 operator*(const Pose2& a_from_b, const Pose2& b_from_c) {
  const double c = std::cos(a_from_b.theta_rad);
  const double s = std::sin(a_from_b.theta_rad);
  return {a_from_b.x + c * b_from_c.x - s * b_from_c.y,
          a_from_b.y + s * b_from_c.x + c * b_from_c.y,
          WrappedAngle(a_from_b.theta_rad + b_from_c.theta_rad)};
}

// b_from_a, given a_from_b.
inline Pose2 Inverse(const Pose2& pose) {
  const double c = std::cos(pose.theta_rad);
  const double s = std::sin(pose.theta_rad);
  return {-c * pose.x - s * pose.y, s * pose.x - c * pose.y, WrappedAngle(-pose.theta_rad)};
}

}  // namespace waystone
