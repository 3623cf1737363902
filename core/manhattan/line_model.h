// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "core/manhattan/manhattan_frame.h"

// The error of a line against a direction and what follows from it: internal to core/manhattan. All
// functions are pure; thread-safe.
namespace waystone {

// What voting and refinement need to know about a line.
struct Line {
  Eigen::Vector3d normal;
  Eigen::Vector3d middle;
  Eigen::Vector3d along;
  double turn_variance = 0;  // of its normal towards `along`: the arc turns about its middle, rad^2
  double shift_variance = 0;  // of its normal towards `middle`: the arc shifts sideways, rad^2
  double weight = 0;          // its length over that of all lines
  int index = 0;              // in the caller's list
};

// The longest `max_lines` lines; equal ones in the caller's order.
std::vector<Line> SelectLines(std::span<const GreatCircle> circles, int max_lines);

// Error l^T v of a line against a direction, over its standard deviation; and how informative the
// line is about that direction: from 1 down to 0, where an arc in any direction would pass.
struct LineError {
  double sigmas = 0;
  double sigma = 1;
  double say = 0;
};
LineError ComputeLineError(const Line& line, const Eigen::Vector3d& direction,
                           const ManhattanOptions& options);

// The axis a line supports most and by how much, 0 to its weight.
struct LineSupport {
  int axis = -1;
  double support = 0;
};
LineSupport ComputeSupport(const Line& line, const Eigen::Matrix3d& rig_from_axes,
                           const ManhattanOptions& options);

// Support of all lines.
double TotalSupport(std::span<const Line> lines, const Eigen::Matrix3d& rig_from_axes,
                    const ManhattanOptions& options);

// A refined rotation and the covariance of its rotation vector.
struct RefinedRotation {
  Eigen::Matrix3d rig_from_axes;
  Eigen::Matrix3d covariance;
};
RefinedRotation RefineRotation(std::span<const Line> lines, const Eigen::Matrix3d& start,
                               const ManhattanOptions& options);

}  // namespace waystone
