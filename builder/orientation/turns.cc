// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/turns.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/geometry/angle.h"
#include "core/geometry/pose2.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

int Sector(double heading_rad) {
  return static_cast<int>(std::lround(heading_rad / kQuarterTurn_rad) + 4) % 4;
}

// Angle from an axis to a heading, (-pi, pi].
double FromAxis(double heading_rad, int sector) {
  return WrappedAngle(heading_rad - sector * kQuarterTurn_rad);
}

// From one axis to another: -1, 0, 1 or 2.
int QuarterTurns(int from, int to) {
  const int turns = (to - from + 4) % 4;
  return turns == 3 ? -1 : turns;
}

bool IsAlongAxis(double heading_rad, const TurnOptions& options) {
  return std::abs(FromAxis(heading_rad, Sector(heading_rad))) <= options.settled_rad;
}

// The change between the median headings of the frames along an axis before the jump and after it.
// For a side without such frames, its heading farthest from the jump is used.
double MeasureTurn(std::span<const HeadingSample> headings, int frame, const TurnOptions& options) {
  const int window = 4 * options.reach;
  std::vector<double> along[2], any[2];  // before, after
  std::optional<double> unwrapped_rad;
  for (const HeadingSample& sample : headings) {
    if (!sample.heading_rad || sample.frame < frame - window) continue;
    if (sample.frame >= frame + window) break;
    const double last_rad = unwrapped_rad.value_or(*sample.heading_rad);
    unwrapped_rad = last_rad + WrappedAngle(*sample.heading_rad - last_rad);
    const int side = sample.frame < frame ? 0 : 1;
    any[side].push_back(*unwrapped_rad);
    if (IsAlongAxis(*sample.heading_rad, options)) along[side].push_back(*unwrapped_rad);
  }
  if (any[0].empty() || any[1].empty()) return 0;
  const double before_rad = along[0].empty() ? any[0].front() : Median(along[0]);
  const double after_rad = along[1].empty() ? any[1].back() : Median(along[1]);
  return std::clamp(after_rad - before_rad, -kPi, kPi);
}

// The direction is that of the heading where it changed clearly, else of the features' motion, else
// of the axes.
int FindTurnDirection(const TestedJump& tested, double angle_rad) {
  if (std::abs(angle_rad) > kQuarterTurn_rad / 2) return angle_rad > 0 ? 1 : -1;
  if (tested.flow_rad != 0) return tested.flow_rad < 0 ? 1 : -1;
  return tested.jump.quarter_turns < 0 ? -1 : 1;
}

// Confirms as many jumps around a change of the motion's axis as the change has quarter turns.
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
    turn->axis_after = after.quarter_turns % 2;
    left -= std::max(1, std::abs(turn->jump.quarter_turns));
  }
}

// The motion's axis after a jump, by the settled motions, else the camera's own.
int AxisAfter(const HeadingJump& jump, std::span<const SettledMotion> motions) {
  for (const SettledMotion& motion : motions) {
    if (motion.last > jump.frame) return motion.quarter_turns % 2;
  }
  return (motions.empty() ? jump.sector_after : motions.back().quarter_turns) % 2;
}

}  // namespace

std::optional<HeadingJump> JumpWatch::Next(int frame, double heading_rad) {
  if (!sector_) {
    sector_ = Sector(heading_rad);
    return std::nullopt;
  }
  const double off = FromAxis(heading_rad, *sector_);
  if (std::abs(off) <= kQuarterTurn_rad / 2 + options_.hysteresis_rad) return std::nullopt;
  const int before = *sector_;
  sector_ = Sector(heading_rad);
  return HeadingJump{
      .frame = frame, .quarter_turns = QuarterTurns(before, *sector_), .sector_after = *sector_};
}

std::vector<SettledMotion> SettledMotions(std::span<const HeadingSample> samples,
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
  for (const HeadingSample& sample : samples) {
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
                                     std::span<const HeadingSample> headings,
                                     const TurnOptions& options) {
  std::vector<DecidedTurn> turns;
  for (const TestedJump& tested : jumps) {
    const double angle_rad = MeasureTurn(headings, tested.jump.frame, options);
    turns.push_back({.jump = tested.jump,
                     .direction = FindTurnDirection(tested, angle_rad),
                     .angle_rad = angle_rad,
                     .confirmed = false,
                     .axis_after = AxisAfter(tested.jump, motions)});
  }
  for (size_t i = 0; options.use_motions && i + 1 < motions.size(); ++i) {
    ConfirmAround(motions[i], motions[i + 1], options, turns);
  }
  for (size_t i = 0; i < turns.size(); ++i) {
    const int frame = turns[i].jump.frame;
    const bool known = options.use_motions && !motions.empty() && motions.front().first < frame &&
                       motions.back().last > frame;
    if (!known && !jumps[i].connected) turns[i].confirmed = true;
  }
  return turns;
}

}  // namespace waystone
