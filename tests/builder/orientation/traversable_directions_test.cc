// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/traversable_directions.h"

#include <gtest/gtest.h>

namespace waystone {
namespace {

// A rig that looks along the building's x: x ahead, y left, z up.
Eigen::Matrix3d LookingAlongX() {
  Eigen::Matrix3d building_from_rig;
  building_from_rig << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return building_from_rig;
}

TEST(TraversableDirections, CellsLieAroundTheWay) {
  const Eigen::Matrix3d head = LookingAlongX();
  const Eigen::Vector3d right(1, 0.1, 2);
  const Eigen::Vector3d up(0.1, -1, 2);
  EXPECT_EQ(CellOf(right, head, 0), DirectionCell::kRight);
  EXPECT_EQ(CellOf(-right, head, 0), DirectionCell::kLeft);
  EXPECT_EQ(CellOf(up, head, 0), DirectionCell::kUp);
  EXPECT_EQ(CellOf(-up, head, 0), DirectionCell::kDown);
  // Who walks back has the right wall on the left.
  EXPECT_EQ(CellOf(right, head, 2), DirectionCell::kLeft);
  EXPECT_EQ(CellOf(up, head, 2), DirectionCell::kUp);
  // Who walks to the left (along y) has what lies ahead of the camera on the right.
  EXPECT_EQ(CellOf({0, 0, 1}, head, 1), DirectionCell::kRight);
  EXPECT_EQ(CellOf({0, 0, 1}, head, 3), DirectionCell::kLeft);
}

TEST(TraversableDirections, CountTheLinesAcrossTheWayAlone) {
  const auto line = [](const Eigen::Vector3d& middle) {
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    GreatCircle circle{.normal = zero, .middle = zero, .along = zero, .segment = {{0, 0}, {0, 0}}};
    circle.middle = middle.normalized();
    return circle;
  };
  const std::vector<GreatCircle> lines{line({-1, 0, 1}), line({-1, 0, 2}), line({1, 0, 1}),
                                       line({0, -1, 1}), line({0, 1, 1}),  line({-1, 0, 1})};
  const std::vector<int> axes{1, 1, 0, 1, -1, 2};
  EXPECT_EQ(TraversableDirections(lines, axes, LookingAlongX(), 0),
            (std::array<int, 4>{1, 0, 0, 2}));
  EXPECT_EQ(TraversableDirections(lines, axes, LookingAlongX(), 1),
            (std::array<int, 4>{0, 1, 0, 0}));
}

}  // namespace
}  // namespace waystone
