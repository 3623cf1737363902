// SPDX-License-Identifier: Apache-2.0
#include "schema/orientation_way.h"

#include <cmath>
#include <numbers>
#include <unordered_map>

namespace waystone {
namespace {

// Quarter turns from the building's x to the axis that is nearest to where a sequence's first frame
// with a rotation looks, 0 to 3.
int FirstQuarter(const OrientationLayer& layer, size_t begin) {
  for (size_t i = begin; i < layer.frames.size(); ++i) {
    const OrientationFrame& frame = layer.frames[i];
    if (frame.sequence != layer.frames[begin].sequence) break;
    if (!frame.reliable) continue;
    const Eigen::Vector3d ahead = frame.rotation->building_from_head * Eigen::Vector3d::UnitZ();
    const double quarters = std::atan2(ahead.y(), ahead.x()) / (std::numbers::pi / 2);
    return (static_cast<int>(std::lround(quarters)) + 4) % 4;
  }
  return 0;
}

// A turn that leaves the motion on its axis is one about.
int QuarterAfter(int before, const OrientationTurn& turn) {
  if (turn.axis_after == before % 2) return (before + 2) % 4;
  return (before + (turn.direction > 0 ? 1 : 3)) % 4;
}

}  // namespace

std::vector<Eigen::Vector2d> WayOf(const OrientationLayer& layer) {
  const Eigen::Vector2d steps[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  std::unordered_map<OrientationFrameId, const OrientationTurn*> turn_at;
  for (const OrientationTurn& turn : layer.turns) {
    if (turn.confirmed) turn_at[turn.frame] = &turn;
  }
  std::vector<Eigen::Vector2d> way;
  int quarter = 0;
  for (size_t i = 0; i < layer.frames.size(); ++i) {
    const OrientationFrame& frame = layer.frames[i];
    if (i == 0 || frame.sequence != layer.frames[i - 1].sequence) {
      quarter = FirstQuarter(layer, i);
      way.emplace_back(0, 0);
      continue;
    }
    const int frames = frame.frame - layer.frames[i - 1].frame;
    way.push_back(way.back() + frames * steps[quarter]);
    const auto turn = turn_at.find(frame.id);
    if (turn != turn_at.end()) quarter = QuarterAfter(quarter, *turn->second);
  }
  return way;
}

}  // namespace waystone
