// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// The paper's three conditions for key frames (sec. IV, after Royer et al.): as many frames as
// possible between two of them, at least M matches with the last one and N with the one before.
struct KeyframeOptions {
  int min_matches_last = 200;        // M
  int min_matches_before_last = 80;  // N
  // Frames looked at beyond the first one that breaks the conditions, so that one blurred frame
  // doesn't end the search.
  int lookahead = 3;
  // Frames that may lie between two keyframes at the most.
  int max_gap = 60;
  // Fewer matches than this with the last keyframe: the sequence is broken, a new stretch starts.
  int min_matches_stretch = 30;

  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
