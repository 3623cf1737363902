// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/manhattan/great_circles.h"

namespace waystone {

// The four cells around the trajectory.
enum class DirectionCell { kUp = 0, kRight = 1, kDown = 2, kLeft = 3 };

// The cell in which a ray of the rig lies for somebody who follows the building's axis
// `quarter_turns` (from x, 0 to 3): the space is divided by the two planes through the trajectory
// at half a right angle (sec. III-C.3).
DirectionCell CellOf(const Eigen::Vector3d& rig_ray, const Eigen::Matrix3d& building_from_rig,
                     int quarter_turns);

// Lines along the horizontal axis perpendicular to the trajectory, counted in the cells up, right,
// down and left: where there are many, one can go. `axis_of_line` as of ManhattanFrame, numbered as
// the building's axes.
std::array<int, 4> TraversableDirections(std::span<const GreatCircle> lines,
                                         std::span<const int> axis_of_line,
                                         const Eigen::Matrix3d& building_from_rig,
                                         int quarter_turns);

}  // namespace waystone
