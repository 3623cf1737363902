// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/turns.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/geometry/angle.h"

namespace waystone {
namespace {

int Sector(double heading_rad) {
  return static_cast<int>(std::lround(heading_rad / kQuarterTurn_rad) + 4) % 4;
}

// Angle from an axis to a heading, (-pi, pi].
double FromAxis(double heading_rad, int sector) {
  return std::remainder(heading_rad - sector * kQuarterTurn_rad, 4 * kQuarterTurn_rad);
}

// From one axis to another: -1, 0, 1 or 2.
int QuarterTurns(int from, int to) {
  const int turns = (to - from + 4) % 4;
  return turns == 3 ? -1 : turns;
}

// The features' motion tells the direction; the heading does where none were matched.
int FindTurnDirection(const TestedJump& tested) {
  if (tested.flow_rad != 0) return tested.flow_rad < 0 ? 1 : -1;
  return tested.jump.quarter_turns < 0 ? -1 : 1;
}

// Confirms as many jumps around a change of the motion's axis as it has quarter turns.
void ConfirmAround(const SettledMotion& before, const SettledMotion& after,
                   const TurnOptions& options, std::vector<DecidedTurn>& turns) {
  std::vector<DecidedTurn*> near;
  int sum = 0;
  for (DecidedTurn& turn : turns) {
    const int frame = turn.jump.frame;
    if (turn.confirmed || frame < before.last - options.reach) continue;
    if (frame > after.first + options.reach) continue;
    near.push_back(&turn);
    sum += turn.direction;
  }
  const int change = QuarterTurns(before.quarter_turns, after.quarter_turns);
  const int direction = change == 2 && sum < 0 ? -1 : (change > 0 ? 1 : -1);
  int left = std::abs(change);
  for (DecidedTurn* turn : near) {
    if (left <= 0 || turn->direction != direction) continue;
    turn->confirmed = true;
    left -= std::max(1, std::abs(turn->jump.quarter_turns));
  }
}

// The motion's axis after a jump: of the stretch that ends last after it has begun, else the
// camera's own.
int AxisAfter(const HeadingJump& jump, std::span<const SettledMotion> motions) {
  for (const SettledMotion& motion : motions) {
    if (motion.last > jump.frame) return motion.quarter_turns % 2;
  }
  return motions.empty() ? 0 : motions.back().quarter_turns % 2;
}

}  // namespace

std::optional<HeadingJump> JumpWatch::Next(int frame, double heading_rad) {
  const double last_rad = last_rad_;
  last_rad_ = heading_rad;
  if (!sector_) {
    sector_ = Sector(heading_rad);
    return std::nullopt;
  }
  const double off = FromAxis(heading_rad, *sector_);
  if (std::abs(off) <= kQuarterTurn_rad / 2 + options_.hysteresis_rad) return std::nullopt;
  const int before = *sector_;
  sector_ = Sector(heading_rad);
  const double angle = FromAxis(heading_rad, *sector_) - FromAxis(last_rad, before);
  return HeadingJump{.frame = frame,
                     .quarter_turns = QuarterTurns(before, *sector_),
                     .angle_rad = std::remainder(angle, 4 * kQuarterTurn_rad)};
}

std::vector<SettledMotion> SettledMotions(std::span<const MotionSample> samples,
                                          const TurnOptions& options) {
  std::vector<SettledMotion> settled;
  SettledMotion run;
  int length = 0;
  const auto close = [&] {
    if (length < options.settled_motions) return;
    if (!settled.empty() && settled.back().quarter_turns == run.quarter_turns) {
      settled.back().last = run.last;
    } else {
      settled.push_back(run);
    }
  };
  for (const MotionSample& sample : samples) {
    if (!sample.heading_rad) continue;
    const int sector = Sector(*sample.heading_rad);
    const bool along = std::abs(FromAxis(*sample.heading_rad, sector)) <= options.settled_rad;
    if (length > 0 && along && sector == run.quarter_turns) {
      run.last = sample.frame;
      ++length;
      continue;
    }
    close();
    run = {.first = sample.frame, .last = sample.frame, .quarter_turns = sector};
    length = along ? 1 : 0;
  }
  close();
  return settled;
}

std::vector<DecidedTurn> DecideTurns(std::span<const TestedJump> jumps,
                                     std::span<const SettledMotion> motions,
                                     const TurnOptions& options) {
  std::vector<DecidedTurn> turns;
  for (const TestedJump& tested : jumps) {
    turns.push_back({.jump = tested.jump,
                     .direction = FindTurnDirection(tested),
                     .confirmed = false,
                     .axis_after = AxisAfter(tested.jump, motions)});
  }
  for (size_t i = 0; i + 1 < motions.size(); ++i) {
    ConfirmAround(motions[i], motions[i + 1], options, turns);
  }
  for (size_t i = 0; i < turns.size(); ++i) {
    const int frame = turns[i].jump.frame;
    const bool known =
        !motions.empty() && motions.front().first < frame && motions.back().last > frame;
    if (!known && !jumps[i].connected) turns[i].confirmed = true;
  }
  return turns;
}

}  // namespace waystone
