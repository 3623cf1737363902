// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/keyframe_sample.h"

#include <utility>

namespace waystone {

void KeyframeSample::Add(KeyframeId keyframe, const Features& features) {
  if (added_++ % stride_ != 0) return;
  if (static_cast<int>(kept_.size()) == max_keyframes_) {  // every other one of them stays
    stride_ *= 2;
    for (size_t i = 0; 2 * i < kept_.size(); ++i) {
      if (i > 0) kept_[i] = std::move(kept_[2 * i]);
    }
    kept_.resize((kept_.size() + 1) / 2);
    if ((added_ - 1) % stride_ != 0) return;
  }
  kept_.push_back({keyframe, features});
}

}  // namespace waystone
