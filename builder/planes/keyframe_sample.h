// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/base/ids.h"
#include "core/features/features.h"

namespace waystone {

// A keyframe with all features that were found in it.
struct SampledKeyframe {
  KeyframeId keyframe;
  Features features;
};

// An image of a sequence with all features that were found in it.
struct WalkImage {
  SequenceId sequence;
  int frame = 0;  // number in the sequence
  Features features;
};

// Keeps the features of at most a given number of keyframes, evenly spread over all that were
// added, however many there will be. Deterministic. Not thread-safe.
class KeyframeSample {
 public:
  explicit KeyframeSample(int max_keyframes) : max_keyframes_(max_keyframes) {}

  void Add(KeyframeId keyframe, const Features& features);
  const std::vector<SampledKeyframe>& keyframes() const { return kept_; }

 private:
  int max_keyframes_;
  int stride_ = 1;
  int added_ = 0;
  std::vector<SampledKeyframe> kept_;
};

}  // namespace waystone
