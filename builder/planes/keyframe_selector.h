// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "builder/sources/source.h"
#include "core/base/options.h"
#include "core/features/features.h"
#include "core/features/match.h"

namespace waystone {

// The paper's three conditions for key frames (sec. IV, after Royer et al.): as many frames as
// possible between two of them, at least M matches with the last one and N with the one before it.
struct KeyframeOptions {
  int min_matches_last = 300;
  int min_matches_before_last = 150;
  int lookahead = 3;
  int max_gap = 60;
  int min_matches_stretch = 30;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"min_matches_last", &KeyframeOptions::min_matches_last, AtLeast(4), "",
                    "M: minimum number of matches with the last keyframe, or 0.6 of its features "
                    "if that is less. Higher values give more keyframes, closer together."},
        OptionField{"min_matches_before_last", &KeyframeOptions::min_matches_before_last,
                    AtLeast(4), "",
                    "N: minimum number of matches with the keyframe before the last, or 0.3 of its "
                    "features if that is less; at most M."},
        OptionField{"lookahead", &KeyframeOptions::lookahead, AtLeast(0), "frames",
                    "Number of frames tried after the first one that violates the conditions, so "
                    "that a single blurred frame doesn't end the search."},
        OptionField{"max_gap", &KeyframeOptions::max_gap, AtLeast(1), "frames",
                    "Maximum distance from one keyframe to the next; bounds the cost while the "
                    "camera stands still."},
        OptionField{"min_matches_stretch", &KeyframeOptions::min_matches_stretch, AtLeast(4), "",
                    "If there are fewer matches with the last keyframe than this, or than 0.3 of "
                    "its features if that is less, the sequence counts as interrupted and a new "
                    "stretch starts; at most N."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// A frame with its features, which may become a keyframe.
struct ExtractedFrame {
  FrameInfo info;
  cv::Mat thumbnail;  // smaller picture of it; empty when images are left out
  Features features;
};

struct ChosenKeyframe {
  ExtractedFrame frame;
  bool starts_stretch = false;  // isn't connected to the keyframe before
};

// Picks keyframes from consecutive frames. Holds at most a handful of frames. Deterministic. Not
// thread-safe.
class KeyframeSelector {
 public:
  KeyframeSelector(const KeyframeOptions& options, const MatchOptions& match);

  // Takes the next frame; returns the keyframes that it decides, in order. A frame with fewer than
  // 8 features never becomes one.
  std::vector<ChosenKeyframe> Add(ExtractedFrame frame);
  // The keyframes still undecided at the end of the sequence.
  std::vector<ChosenKeyframe> Finish();

 private:
  struct Candidate {
    ExtractedFrame frame;
    int matches_last = 0;
  };

  void Consider(ExtractedFrame frame, std::vector<ChosenKeyframe>& chosen);
  void Decide(std::vector<ChosenKeyframe>& chosen);
  void Choose(ExtractedFrame frame, bool starts_stretch, std::vector<ChosenKeyframe>& chosen);
  bool FulfilsConditions(const Features& frame, int matches_last) const;
  bool IsShownBy(const Candidate& candidate, const Features& next) const;
  int CountMatches(const Features& a, const Features& b) const;

  KeyframeOptions options_;
  MatchOptions match_;
  std::optional<Features> last_;         // of the last keyframe, I_{i-1}
  std::optional<Features> before_last_;  // of I_{i-2}, in the same stretch
  int gap_ = 0;                          // frames since the last keyframe
  std::optional<ExtractedFrame> best_;   // the farthest frame that fulfils the conditions
  std::deque<Candidate> beyond_;         // frames after it that don't
};

}  // namespace waystone
