// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/keyframe_sample.h"

#include <utility>

namespace waystone {

void KeyframeSample::Add(KeyframeId keyframe, const Features& features) {
  const int number = added_++;
  if (number % stride_ != 0) return;
  if (static_cast<int>(kept_.size()) == max_keyframes_) {  // keep every other one
    stride_ *= 2;
    std::vector<SampledKeyframe> staying;
    for (size_t i = 0; i < kept_.size(); i += 2) staying.push_back(std::move(kept_[i]));
    kept_ = std::move(staying);
    if (number % stride_ != 0) return;
  }
  kept_.push_back({keyframe, features});
}

}  // namespace waystone
