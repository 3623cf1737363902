// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/options.h"

namespace waystone {

// The sizes that turn the characters of a plan into metres.
struct PlanOptions {
  double cell_m = 0.5;
  double wall_height_m = 2.6;
  double door_height_m = 2.05;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{
            "cell_m", &PlanOptions::cell_m, Closed(0.1, 5), "m",
            "Side of a cell. Smaller cells give thinner walls, but make the plan larger to type."},
        OptionField{"wall_height_m", &PlanOptions::wall_height_m, Closed(1, 20), "m",
                    "Height from floor to ceiling. Higher rooms show less ceiling and more wall."},
        OptionField{
            "door_height_m", &PlanOptions::door_height_m, AtLeast(0.5), "m",
            "Height from the floor to the underside of a door's lintel, at most wall_height_m, "
            "which means no lintel. A lower one hides more of the next room."});
  }
  // Throws MapError(kBadOptions) for a value out of its range.
  void Check() const;
};

// A floor plan: a grid of cells seen from above, north up.
//
//   '#'        a cell filled by wall
//   '.' or ' ' floor
//   'D'        a door: floor with a lintel above
//   'a'..'z'   wall that carries a poster on each of its faces; same letter, same poster
//   '1'..'9'   floor where the demo walk stops, in this order
//
// A cell has a column (eastwards from 0) and a row (southwards from 0, as the lines are read).
// The world frame's origin is the south-west corner of the plan at floor height; x points east,
// y north, z up; metres.
struct FloorPlan {
  PlanOptions size;
  int columns = 0;
  int rows = 0;
  std::vector<std::string> lines;      // `rows` lines of `columns` characters
  std::vector<Eigen::Vector2i> stops;  // (column, row) of '1', '2', ...

  // Whether the cell is floor or a door. Cells outside the plan are wall.
  bool IsOpen(int column, int row) const;
  bool IsDoor(int column, int row) const;
  // The letter of the poster that a wall cell carries, or 0.
  char PosterAt(int column, int row) const;
  // Centre of a cell, world frame.
  Eigen::Vector2d CentreOf(const Eigen::Vector2i& cell) const;
  // Whether a square of half side `clearance_m` around a point of the world frame touches no wall.
  bool IsFree(const Eigen::Vector2d& point, double clearance_m) const;
  // The plan as it was typed, one line per row, with short lines padded.
  std::string Text() const;
};

// Parses a plan. Empty lines before and after it, and carriage returns, are ignored; short lines
// are padded with wall. Throws MapError(kBadOptions), naming line and column (both from 1), for an
// unknown character, floor at the plan's edge, a stop that is missing or duplicated, a plan without
// floor, and one of more than 1000 lines or columns. Pure; thread-safe.
FloorPlan ParseFloorPlan(std::string_view text, const PlanOptions& size = {});

}  // namespace waystone
