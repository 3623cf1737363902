// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/options.h"

#include "core/base/option_range.h"

namespace waystone {

void FollowOptions::Check() const {
  CheckRange("max_jump_rad", max_jump_rad, 0.01, 0.7);
  CheckRange("max_drift_rad", max_drift_rad, 0.01, 0.5);
  CheckRange("max_rival_drift_rad", max_rival_drift_rad, 0.005, 0.5);
  CheckRange("max_clear_rival", max_clear_rival, 0, 1);
  CheckRange("min_votes", min_votes, 1, 100);
  CheckRange("step_sigma_rad", step_sigma_rad, 1e-5, 0.1);
  CheckRange("anchor_frames", anchor_frames, 1, 1000);
  CheckRange("retry_frames", retry_frames, 1, 100);
}

void TraversabilityOptions::Check() const {
  matching.Check();
  relative.Check();
  CheckRange("max_disagreement_rad", max_disagreement_rad, 0.005, 0.5);
  CheckRange("min_parallax_rad", min_parallax_rad, 0.0005, 0.5);
}

void TurnOptions::Check() const {
  CheckRange("hysteresis_rad", hysteresis_rad, 0, 0.5);
  CheckRange("reach", reach, 1, 100);
  CheckRange("settled_rad", settled_rad, 0.05, 0.7);
  CheckRange("settled_motions", settled_motions, 1, 100);
}

void CorridorOptions::Check() const {
  CheckRange("heading_range_rad", heading_range_rad, 0.05, 1.5);
  CheckRange("min_ratio", min_ratio, 1, 20);
  CheckRange("min_frames", min_frames, 1, 100'000);
  CheckRange("max_gap_frames", max_gap_frames, 0, 1000);
}

void OrientationLoopOptions::Check() const {
  CheckRange("min_gap_frames", min_gap_frames, 1, 1'000'000);
  CheckRange("sample", sample, 10, 10'000);
  CheckRange("candidates", candidates, 1, 1000);
  CheckRange("min_matches", min_matches, 5, 10'000);
  CheckRange("max_log10_chance", max_log10_chance, -300, 0);
  CheckRange("max_turn_rad", max_turn_rad, 0.05, 3.2);
  CheckRange("max_disagreement_rad", max_disagreement_rad, 0.005, 0.5);
}

void OrientationOptions::Check() const {
  segments.Check();
  circles.Check();
  manhattan.Check();
  bearings.Check();
  follow.Check();
  traversability.Check();
  CheckRange("step", step, 1, 1000);
  CheckRange("motion_frames", motion_frames, 1, 100);
  turns.Check();
  corridors.Check();
  loops.Check();
  CheckRange("image_width", image_width, 0, 4096);
}

}  // namespace waystone
