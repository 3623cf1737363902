// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/corridors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "builder/orientation/follow.h"

namespace waystone {
namespace {

struct Stretch {
  int first = 0;
  int last = -1;  // inclusive
  int axis = 0;

  int frames() const { return last - first + 1; }
};

// Takes away the axes of frames in which the motion follows the other one.
void HeedMotion(std::span<const SettledMotion> motions, std::vector<int>& axes) {
  for (const SettledMotion& motion : motions) {
    for (int i = motion.first; i <= motion.last; ++i) {
      if (axes[i] != motion.quarter_turns % 2) axes[i] = -1;
    }
  }
}

// Runs of one axis, with gaps, that no turn cuts.
std::vector<Stretch> Runs(std::span<const int> axes, std::span<const int> turns, int max_gap) {
  std::vector<Stretch> runs;
  size_t turn = 0;
  bool cut = true;
  for (int i = 0; i < static_cast<int>(axes.size()); ++i) {
    for (; turn < turns.size() && turns[turn] <= i; ++turn) cut = true;
    if (axes[i] < 0) continue;
    if (cut || runs.back().axis != axes[i] || i - runs.back().last > max_gap + 1) {
      runs.push_back({i, i, axes[i]});
    } else {
      runs.back().last = i;
    }
    cut = false;
  }
  return runs;
}

// The longest part of a stretch whose headings lie in a range; the first of equal ones.
Stretch LongestInRange(std::span<const OrientationFrame> frames, const Stretch& stretch,
                       double range_rad) {
  Stretch best{stretch.first, stretch.first - 1, stretch.axis};
  std::multiset<double> headings;
  const auto of = [&](int i) {
    const double along = stretch.axis * std::numbers::pi / 2;
    return std::remainder(*HeadingOf(frames[i]) - along, 2 * std::numbers::pi);
  };
  int first = stretch.first;
  for (int i = stretch.first; i <= stretch.last; ++i) {
    if (!frames[i].rotation) continue;
    headings.insert(of(i));
    for (; *headings.rbegin() - *headings.begin() > range_rad; ++first) {
      if (frames[first].rotation) headings.erase(headings.find(of(first)));
    }
    if (i - first + 1 > best.frames()) best = {first, i, stretch.axis};
  }
  return best;
}

// The longest part first, then what is left on both sides of it.
void SplitByHeading(std::span<const OrientationFrame> frames, const Stretch& stretch,
                    const CorridorOptions& options, std::vector<Stretch>& corridors) {
  if (stretch.frames() < options.min_frames) return;
  const Stretch best = LongestInRange(frames, stretch, options.heading_range_rad);
  if (best.frames() < options.min_frames) return;
  SplitByHeading(frames, {stretch.first, best.first - 1, stretch.axis}, options, corridors);
  corridors.push_back(best);
  SplitByHeading(frames, {best.last + 1, stretch.last, stretch.axis}, options, corridors);
}

}  // namespace

std::vector<int> DominantAxes(std::span<const OrientationFrame> frames,
                              const CorridorOptions& options) {
  const int n = static_cast<int>(frames.size());
  std::vector<std::array<int64_t, 2>> sums(n + 1);  // lines of all frames before
  for (int i = 0; i < n; ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      sums[i + 1][axis] = sums[i][axis] + (frames[i].reliable ? frames[i].lines[axis] : 0);
    }
  }
  std::vector<int> axes(n, -1);
  for (int i = 0; i < n; ++i) {
    if (!frames[i].reliable) continue;
    const int first = std::max(0, i - options.smooth_frames);
    const int end = std::min(n, i + options.smooth_frames + 1);
    const auto x = static_cast<double>(sums[end][0] - sums[first][0]);
    const auto y = static_cast<double>(sums[end][1] - sums[first][1]);
    if (x > 0 && x >= options.min_ratio * y) axes[i] = 0;
    if (y > 0 && y >= options.min_ratio * x) axes[i] = 1;
  }
  return axes;
}

std::vector<Corridor> FindCorridors(std::span<const OrientationFrame> frames,
                                    std::span<const int> turns,
                                    std::span<const SettledMotion> motions,
                                    const CorridorOptions& options) {
  std::vector<int> axes = DominantAxes(frames, options);
  HeedMotion(motions, axes);
  std::vector<Stretch> stretches;
  for (const Stretch& run : Runs(axes, turns, options.max_gap_frames)) {
    SplitByHeading(frames, run, options, stretches);
  }
  std::vector<Corridor> corridors;
  for (const Stretch& stretch : stretches) {
    corridors.push_back({frames[stretch.first].id, frames[stretch.last].id, stretch.axis});
  }
  return corridors;
}

}  // namespace waystone
