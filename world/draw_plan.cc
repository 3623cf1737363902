// SPDX-License-Identifier: Apache-2.0
#include "world/draw_plan.h"

#include "core/base/check.h"

namespace waystone {

cv::Mat DrawPlan(const FloorPlan& plan, int cell_px) {
  WS_CHECK(cell_px >= 1, "cells of a drawing");
  constexpr uint8_t kWall = 0, kDoor = 225, kFloor = 255;
  cv::Mat drawing(plan.rows * cell_px, plan.columns * cell_px, CV_8UC1);
  for (int row = 0; row < plan.rows; ++row) {
    for (int column = 0; column < plan.columns; ++column) {
      const uint8_t grey = plan.IsDoor(column, row)   ? kDoor
                           : plan.IsOpen(column, row) ? kFloor
                                                      : kWall;
      drawing({column * cell_px, row * cell_px, cell_px, cell_px}).setTo(grey);
    }
  }
  return drawing;
}

}  // namespace waystone
