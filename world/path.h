// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "world/floor_plan.h"

namespace waystone {

// The shortest way over open cells from one cell (column, row) to another, both included, that
// keeps away from walls where it can. Throws MapError(kBadOptions) where there is none. All
// functions here are pure; thread-safe.
std::vector<Eigen::Vector2i> FindPath(const FloorPlan& plan, const Eigen::Vector2i& from,
                                      const Eigen::Vector2i& to);

// The polyline as points at most `step_m` apart.
std::vector<Eigen::Vector2d> Resampled(const std::vector<Eigen::Vector2d>& line, double step_m);

// The line with its corners rounded off over about `radius_m`; its ends stay, and no point gets
// nearer to a wall than `clearance_m` unless it already was. `line` comes from Resampled(step_m).
std::vector<Eigen::Vector2d> Smoothed(const FloorPlan& plan, std::vector<Eigen::Vector2d> line,
                                      double step_m, double radius_m, double clearance_m);

}  // namespace waystone
