// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "builder/orientation/options.h"

namespace waystone {

// A change of about pi / 2 in the angle of the main horizontal axis between two frames: another one
// of the building's axes is now nearest to the view ahead.
struct HeadingJump {
  int frame = 0;          // index in the sequence: the one after the jump
  int quarter_turns = 0;  // 1 to the left, -1 to the right, 2 about; by the heading
  int sector_after = 0;   // quarter turns from x to the main horizontal axis after it, 0 to 3
};

// Detects jumps in the headings of consecutive frames. Not thread-safe.
class JumpWatch {
 public:
  explicit JumpWatch(const TurnOptions& options) : options_(options) {}

  std::optional<HeadingJump> Next(int frame, double heading_rad);

 private:
  TurnOptions options_;
  std::optional<int> sector_;  // quarter turns from x to the main horizontal axis, 0 to 3
};

// A jump and what the test between the frames `reach` before and after it said.
struct TestedJump {
  HeadingJump jump;
  bool connected = false;
  double flow_rad = 0;  // mean motion of the features, above 0 to the left
};

// A heading in the building at a frame. The motion's is unknown where it hardly moved, the camera's
// where no axes were found.
struct HeadingSample {
  int frame = 0;
  std::optional<double> heading_rad;
};

// Frames in which the motion follows one axis in one direction.
struct SettledMotion {
  int first = 0;
  int last = 0;
  int quarter_turns = 0;  // from x, 0 to 3
};

// Neighbours differ in their axis or direction. Samples in order of frames. Pure; thread-safe.
std::vector<SettledMotion> SettledMotions(std::span<const HeadingSample> samples,
                                          const TurnOptions& options);

struct DecidedTurn {
  HeadingJump jump;
  int direction = 1;     // 1 left, -1 right
  double angle_rad = 0;  // by which the camera's heading changed, [-pi, pi], above 0 to the left
  bool confirmed = false;
  int axis_after = 0;  // of the motion, or of the camera where that is unknown: 0 x, 1 y
};

// Which jumps are turns (sec. II-B.1): a jump is a turn where the motion around it changes to
// another axis, in the direction in which the rig turned. Only the paper's test (not connected
// means turned) decides where the motion before or after it is unknown (with options.use_motions
// false, everywhere): cameras that see all around stay connected through a turn. `headings` are the
// camera's, in order of frames; a turn's angle is the change of their median over the frames along
// an axis within 4 reaches before and after it. Pure; thread-safe.
std::vector<DecidedTurn> DecideTurns(std::span<const TestedJump> jumps,
                                     std::span<const SettledMotion> motions,
                                     std::span<const HeadingSample> headings,
                                     const TurnOptions& options);

}  // namespace waystone
