// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/traversable_directions.h"

#include <cmath>

#include "core/base/check.h"

namespace waystone {
namespace {

// The direction to the left when looking along an axis.
Eigen::Vector3d LeftOf(int quarter_turns) {
  constexpr std::array<double, 4> kCos{1, 0, -1, 0};
  const auto turn = static_cast<size_t>(quarter_turns);
  return {-kCos[(turn + 3) % 4], kCos[turn], 0};
}

}  // namespace

DirectionCell CellOf(const Eigen::Vector3d& rig_ray, const Eigen::Matrix3d& building_from_rig,
                     int quarter_turns) {
  const Eigen::Vector3d ray = building_from_rig * rig_ray;
  const double left = ray.dot(LeftOf(quarter_turns));
  if (std::abs(ray.z()) >= std::abs(left)) {
    return ray.z() >= 0 ? DirectionCell::kUp : DirectionCell::kDown;
  }
  return left > 0 ? DirectionCell::kLeft : DirectionCell::kRight;
}

std::array<int, 4> TraversableDirections(std::span<const GreatCircle> lines,
                                         std::span<const int> axis_of_line,
                                         const Eigen::Matrix3d& building_from_rig,
                                         int quarter_turns) {
  WS_CHECK(lines.size() == axis_of_line.size(), "an axis a line");
  const int across = 1 - quarter_turns % 2;
  std::array<int, 4> counts{};
  for (size_t i = 0; i < lines.size(); ++i) {
    if (axis_of_line[i] != across) continue;
    ++counts[static_cast<size_t>(CellOf(lines[i].middle, building_from_rig, quarter_turns))];
  }
  return counts;
}

}  // namespace waystone
