// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "world/floor_plan.h"

namespace waystone {

// A plan as an architect draws it: CV_8UC1, north up, cells of `cell_px` pixels, 1 or more
// (WS_CHECK). Walls are black, floor is white, doors are grey. (x, y) of the world frame is at (x,
// rows cell_m - y) cell_px / cell_m. Pure; thread-safe.
cv::Mat DrawPlan(const FloorPlan& plan, int cell_px);

}  // namespace waystone
