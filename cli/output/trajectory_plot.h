// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/trajectory/shape_difference.h"

namespace waystone {

// A line of a plot.
struct PlotLine {
  std::string label;
  std::string colour;  // CSS
  Points2 points;      // metres
};

// An SVG picture of trajectories seen from above, x to the right, y up, at one scale for both, with
// a grid, a legend and a mark where each begins. Every line has a point, and all are finite. Pure;
// thread-safe.
std::string PlotTrajectories(const std::string& title, const std::vector<PlotLine>& lines);

}  // namespace waystone
