// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/corridors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "builder/orientation/follow.h"
#include "core/geometry/angle.h"
#include "core/geometry/pose2.h"

namespace waystone {
namespace {

struct Stretch {
  int first = 0;
  int last = -1;  // inclusive

  int frames() const { return last - first + 1; }
};

// Headings without jumps at half a turn; nothing where there is no rotation.
std::vector<std::optional<double>> Unwrapped(std::span<const OrientationFrame> frames) {
  std::vector<std::optional<double>> headings;
  double last = 0;
  for (const OrientationFrame& frame : frames) {
    std::optional<double> heading = HeadingOf(frame);
    if (heading) last += WrappedAngle(*heading - last);
    headings.push_back(heading ? std::optional(last) : std::nullopt);
  }
  return headings;
}

// The longest part of a stretch whose headings are known except for short gaps and lie in a range;
// the first of equal ones.
Stretch LongestInRange(std::span<const std::optional<double>> headings, const Stretch& stretch,
                       const CorridorOptions& options) {
  Stretch best{stretch.first, stretch.first - 1};
  std::multiset<double> inside;
  int first = stretch.first;
  int known = stretch.first - 1;  // last frame with a heading
  for (int i = stretch.first; i <= stretch.last; ++i) {
    if (!headings[i]) continue;
    if (i - known > options.max_gap_frames + 1) {
      inside.clear();
      first = i;
    }
    known = i;
    inside.insert(*headings[i]);
    for (; *inside.rbegin() - *inside.begin() > options.heading_range_rad; ++first) {
      if (headings[first]) inside.erase(inside.find(*headings[first]));
    }
    if (i - first + 1 > best.frames()) best = {first, i};
  }
  return best;
}

// The longest part first, then what is left on both sides of it.
void SplitByHeading(std::span<const std::optional<double>> headings, const Stretch& stretch,
                    const CorridorOptions& options, std::vector<Stretch>& parts) {
  if (stretch.frames() < options.min_frames) return;
  const Stretch best = LongestInRange(headings, stretch, options);
  if (best.frames() < options.min_frames) return;
  SplitByHeading(headings, {stretch.first, best.first - 1}, options, parts);
  parts.push_back(best);
  SplitByHeading(headings, {best.last + 1, stretch.last}, options, parts);
}

// The horizontal axis along which clearly more lines run in a stretch: 0 x, 1 y, -1 neither.
int DominantAxis(std::span<const OrientationFrame> frames, const Stretch& stretch,
                 double min_ratio) {
  std::array<double, 2> lines{};
  for (int i = stretch.first; i <= stretch.last; ++i) {
    if (!frames[i].reliable) continue;
    for (int axis = 0; axis < 2; ++axis) lines[axis] += frames[i].lines[axis];
  }
  if (lines[0] > 0 && lines[0] >= min_ratio * lines[1]) return 0;
  if (lines[1] > 0 && lines[1] >= min_ratio * lines[0]) return 1;
  return -1;
}

// Whether the motion follows an axis in more of a stretch than it follows the other one.
bool MotionAllows(std::span<const SettledMotion> motions, const Stretch& stretch, int axis) {
  int along = 0;
  for (const SettledMotion& motion : motions) {
    const int frames =
        std::min(motion.last, stretch.last) - std::max(motion.first, stretch.first) + 1;
    along += (motion.quarter_turns % 2 == axis ? 1 : -1) * std::max(0, frames);
  }
  return along >= 0;
}

}  // namespace

std::vector<Corridor> FindCorridors(std::span<const OrientationFrame> frames,
                                    std::span<const int> turns,
                                    std::span<const SettledMotion> motions,
                                    const CorridorOptions& options) {
  const std::vector<std::optional<double>> headings = Unwrapped(frames);
  std::vector<Stretch> parts;
  int first = 0;
  const auto until = [&](int end) {
    SplitByHeading(headings, {first, end - 1}, options, parts);
    first = end;
  };
  for (const int turn : turns) until(turn);
  until(static_cast<int>(frames.size()));
  std::vector<Corridor> corridors;
  for (const Stretch& part : parts) {
    const int axis = DominantAxis(frames, part, options.min_ratio);
    if (axis < 0 || !MotionAllows(motions, part, axis)) continue;
    corridors.push_back({frames[part.first].id, frames[part.last].id, axis});
  }
  return corridors;
}

}  // namespace waystone
