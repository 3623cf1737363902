// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdio>
#include <string>

#include "world/walk.h"

// The drawing of the building that `waystone demo --write` adds to its walk: plan.png.
namespace waystone {

inline constexpr int kPlanCell = 20;  // px of the drawing; half a metre

// Where the drawing has a point of the building.
inline Eigen::Vector2d PixelOf(double x, double y) {
  const FloorPlan plan = DemoPlan();
  return kPlanCell * Eigen::Vector2d(x / plan.size.cell_m, plan.rows - y / plan.size.cell_m);
}

// "PX,PY=X,Y", as `waystone plan --anchor` takes it.
inline std::string AnchorAt(double x, double y) {
  const Eigen::Vector2d px = PixelOf(x, y);
  char text[100];
  (void)std::snprintf(text, sizeof text, "%g,%g=%g,%g", px.x(), px.y(), x, y);
  return text;
}

}  // namespace waystone
