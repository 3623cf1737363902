// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "core/manhattan/great_circles.h"

namespace waystone {

// The four cells around the trajectory.
enum class DirectionCell { kUp = 0, kRight = 1, kDown = 2, kLeft = 3 };

// The cell in which a ray of the rig lies, seen along the direction `quarter_turns` from the
// building's x (0 to 3): space is divided by the two planes through the trajectory at 45 degrees
// (sec. III-C.3). Pure; thread-safe.
DirectionCell CellOf(const Eigen::Vector3d& rig_ray, const Eigen::Matrix3d& building_from_rig,
                     int quarter_turns);

// Lines along the horizontal axis perpendicular to the trajectory, counted in the cells up, right,
// down and left: a direction with many is traversable. `axis_of_line` is as in ManhattanFrame,
// numbered as the building's axes, one per line (CheckFailure). Pure; thread-safe.
std::array<int, 4> TraversableDirections(std::span<const GreatCircle> lines,
                                         std::span<const int> axis_of_line,
                                         const Eigen::Matrix3d& building_from_rig,
                                         int quarter_turns);

}  // namespace waystone
