// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/orientation/orientation_trajectory.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace waystone {
namespace {

// Mean of the frames' gaze along an axis, below which they look across it.
constexpr double kLeastAhead = 0.3;

// Frames between two turns: rows `first` to `last`, with the turn that led to the first.
struct Straight {
  size_t first = 0;
  size_t last = 0;
  const OrientationTurn* turn = nullptr;  // nothing at the beginning of a sequence
};

std::vector<Straight> FindStraights(const OrientationLayer& layer) {
  std::unordered_map<OrientationFrameId, const OrientationTurn*> turn_at;
  for (const OrientationTurn& turn : layer.turns) {
    if (turn.confirmed) turn_at[turn.frame] = &turn;
  }
  std::vector<Straight> straights;
  for (size_t i = 0; i < layer.frames.size(); ++i) {
    if (i == 0 || layer.frames[i].sequence != layer.frames[i - 1].sequence) {
      straights.push_back({i, i, nullptr});
    } else if (const auto turn = turn_at.find(layer.frames[i - 1].id); turn != turn_at.end()) {
      straights.push_back({i, i, turn->second});
    }
    straights.back().last = i;
  }
  return straights;
}

// The frames' mean viewing direction, in the building's plane.
Eigen::Vector2d MeanGaze(const OrientationLayer& layer, const Straight& straight) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (size_t i = straight.first; i <= straight.last; ++i) {
    const OrientationFrame& frame = layer.frames[i];
    if (!frame.reliable) continue;
    const Eigen::Vector3d ahead = frame.rotation->building_from_rig * Eigen::Vector3d::UnitZ();
    sum += ahead.head<2>();
    ++count;
  }
  return sum / std::max(1, count);
}

// The axis of a straight: that of its turn; before the first turn, the other one than after it.
int FindAxis(const Straight& straight, const Straight* next, const Eigen::Vector2d& gaze) {
  if (straight.turn) return straight.turn->axis_after;
  if (next && next->turn) return 1 - next->turn->axis_after;
  return std::abs(gaze.x()) >= std::abs(gaze.y()) ? 0 : 1;
}

// A step along the axis.
Eigen::Vector2d StepOf(int axis, const Straight& straight, const Eigen::Vector2d& gaze,
                       const Eigen::Vector2d& before) {
  double sense = gaze(axis);
  if (std::abs(sense) < kLeastAhead && straight.turn) {
    const double turn = straight.turn->direction;
    sense = Eigen::Vector2d(-turn * before.y(), turn * before.x())(axis);
  }
  Eigen::Vector2d step = Eigen::Vector2d::Zero();
  step(axis) = sense < 0 ? -1 : 1;
  return step;
}

}  // namespace

std::optional<double> HeadingOf(const BuildingRotation& rotation) {
  const Eigen::Vector3d ahead = rotation.building_from_rig * Eigen::Vector3d::UnitZ();
  if (std::hypot(ahead.x(), ahead.y()) < 1e-6) return std::nullopt;
  return std::atan2(ahead.y(), ahead.x());
}

std::vector<Eigen::Vector2d> ComputeTrajectory(const OrientationLayer& layer) {
  std::vector<Eigen::Vector2d> trajectory;
  const std::vector<Straight> straights = FindStraights(layer);
  Eigen::Vector2d step(1, 0);
  for (size_t s = 0; s < straights.size(); ++s) {
    const Straight* next = s + 1 < straights.size() ? &straights[s + 1] : nullptr;
    const Eigen::Vector2d gaze = MeanGaze(layer, straights[s]);
    step = StepOf(FindAxis(straights[s], next, gaze), straights[s], gaze, step);
    for (size_t i = straights[s].first; i <= straights[s].last; ++i) {
      const bool begins = i == 0 || layer.frames[i].sequence != layer.frames[i - 1].sequence;
      const int frames = begins ? 0 : layer.frames[i].frame - layer.frames[i - 1].frame;
      trajectory.push_back(begins ? Eigen::Vector2d::Zero().eval()
                                  : (trajectory.back() + frames * step).eval());
    }
  }
  return trajectory;
}

}  // namespace waystone
