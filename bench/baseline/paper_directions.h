// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "core/manhattan/great_circles.h"

namespace waystone::bench {

// The dominant directions of Rituerto et al. (2011) as in sec. II-A, to compare with
// FindManhattanFrame: every pair of lines gives a putative vanishing point v_m = l_i x l_j, lines
// with |l^T v_m| below `max_error_rad` vote for it, the one with the most votes is the first
// direction, the one with the most votes of those orthogonal to it within `max_skew_rad` the
// second, and the third is their cross product. Nothing is refined. Columns are the directions in
// the rig's frame, made orthogonal; nothing with fewer than three lines or where no second
// direction is found. With more than `max_lines` lines, the longest are used.
std::optional<Eigen::Matrix3d> FindDirectionsByVotes(std::span<const GreatCircle> lines,
                                                     double max_error_rad = 0.01,
                                                     double max_skew_rad = 0.05,
                                                     int max_lines = 300);

}  // namespace waystone::bench
