// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/line_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/geometry/linear_algebra.h"
#include "core/geometry/rotation.h"

namespace waystone {
namespace {

// Length of a step at which refinement has converged, rad.
constexpr double kArrived = 1e-7;
// The variance of a rotation that the lines don't constrain at all, rad^2 (a quarter turn's).
constexpr double kFreeVariance = 1.0;

Line LineOf(const GreatCircle& circle, int index) {
  const double end_variance = circle.end_sigma_rad * circle.end_sigma_rad;
  const double length = std::max(circle.length_rad, 1e-9);
  // Ends at +-length / 2 with independent errors e1, e2 across the arc: it turns by
  // (e2 - e1) / length and shifts by (e1 + e2) / 2.
  return {.normal = circle.normal,
          .middle = circle.middle,
          .along = circle.along,
          .turn_variance = 2 * end_variance / (length * length),
          .shift_variance = 0.5 * end_variance,
          .weight = circle.length_rad,
          .index = index};
}

// Gauss-Newton's equations h w = -g for a rotation vector w.
struct NormalEquations {
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
};

// With v = exp(w) R e_a the error is l^T v = l^T R e_a + w^T (R e_a x l) to first order. Cauchy's
// kernel, times the line's `say`.
std::array<NormalEquations, 3> LineariseAxes(std::span<const Line> lines,
                                             const Eigen::Matrix3d& rotation,
                                             const ManhattanOptions& options) {
  std::array<NormalEquations, 3> axes;
  for (const Line& line : lines) {
    const LineSupport best = ComputeSupport(line, rotation, options);
    if (best.axis < 0) continue;
    const Eigen::Vector3d v = rotation.col(best.axis);
    const LineError error = ComputeLineError(line, v, options);
    const double weight = error.say / (1 + error.sigmas * error.sigmas);
    const Eigen::Vector3d j = v.cross(line.normal) / error.sigma;
    axes[best.axis].h += weight * j * j.transpose();
    axes[best.axis].g += weight * error.sigmas * j;
  }
  return axes;
}

// All lines of an axis share the error of the calibration and the building: an error of the axis as
// a whole with variance s^2. Marginalised, the information h of an axis becomes (h^-1 + s^2 I)^-1 =
// (I + s^2 h)^-1 h: a thousand lines don't outweigh the other axes.
NormalEquations Linearise(std::span<const Line> lines, const Eigen::Matrix3d& rotation,
                          const ManhattanOptions& options) {
  const double shared_variance = options.axis_sigma_rad * options.axis_sigma_rad;
  NormalEquations sum;
  for (const NormalEquations& axis : LineariseAxes(lines, rotation, options)) {
    const Eigen::Matrix3d shrink =
        (Eigen::Matrix3d::Identity() + shared_variance * axis.h).inverse();
    sum.h += shrink * axis.h;
    sum.g += shrink * axis.g;
  }
  sum.h += Eigen::Matrix3d::Identity() / kFreeVariance;
  return sum;
}

}  // namespace

std::vector<Line> SelectLines(std::span<const GreatCircle> circles, int max_lines) {
  std::vector<int> order(circles.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return circles[a].length_rad > circles[b].length_rad; });
  order.resize(std::min(order.size(), static_cast<size_t>(max_lines)));
  std::vector<Line> lines;
  double total = 0;
  for (const int i : order) {
    lines.push_back(LineOf(circles[i], i));
    total += lines.back().weight;
  }
  for (Line& line : lines) line.weight /= total;
  return lines;
}

LineError ComputeLineError(const Line& line, const Eigen::Vector3d& direction,
                           const ManhattanOptions& options) {
  const double to_along = line.along.dot(direction);
  const double to_middle = line.middle.dot(direction);
  const double sigma = std::sqrt(options.line_sigma_rad * options.line_sigma_rad +
                                 line.turn_variance * to_along * to_along +
                                 line.shift_variance * to_middle * to_middle);
  // At angle t from the direction, an arc turned by any angle has l^T v of at most sin t.
  const double sine = std::sqrt(std::max(0.0, 1 - to_middle * to_middle));
  const double say = 1 - std::min(1.0, options.max_sigmas * sigma / std::max(sine, 1e-9));
  return {.sigmas = line.normal.dot(direction) / sigma, .sigma = sigma, .say = say};
}

LineSupport ComputeSupport(const Line& line, const Eigen::Matrix3d& rig_from_axes,
                           const ManhattanOptions& options) {
  LineSupport best;
  // No line's error can have a larger sigma than this.
  const double bound =
      options.max_sigmas * std::sqrt(options.line_sigma_rad * options.line_sigma_rad +
                                     std::max(line.turn_variance, line.shift_variance));
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(line.normal.dot(rig_from_axes.col(axis))) > bound) continue;
    const LineError error = ComputeLineError(line, rig_from_axes.col(axis), options);
    const double ratio = error.sigmas / options.max_sigmas;
    const double support = line.weight * error.say * (1 - ratio * ratio);
    if (support > best.support) best = {axis, support};
  }
  return best;
}

double TotalSupport(std::span<const Line> lines, const Eigen::Matrix3d& rig_from_axes,
                    const ManhattanOptions& options) {
  double total = 0;
  for (const Line& line : lines) total += ComputeSupport(line, rig_from_axes, options).support;
  return total;
}

RefinedRotation RefineRotation(std::span<const Line> lines, const Eigen::Matrix3d& start,
                               const ManhattanOptions& options) {
  Eigen::Matrix3d rotation = start;
  for (int step = 0; step < options.max_steps; ++step) {
    const NormalEquations sum = Linearise(lines, rotation, options);
    const Eigen::Vector3d w = -SolveSymmetric(sum.h, sum.g);
    rotation = RotationByVector(w) * rotation;
    if (w.norm() < kArrived) break;
  }
  rotation = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  return {rotation, Linearise(lines, rotation, options).h.inverse()};
}

}  // namespace waystone
