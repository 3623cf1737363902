// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/image_features.h"

#include "core/base/clock.h"

namespace waystone {

const ImageFeatures::Timed& ImageFeatures::Extract(const cv::Mat& grey, const FeatureOptions& how) {
  const auto key = std::pair(how.type, how.working_pixels);
  const auto it = extracted_.find(key);
  if (it != extracted_.end()) return it->second;
  LapTimer timer;
  Timed timed{ExtractFeatures(grey, how), 0};
  timed.ms = timer.Lap();
  return extracted_.emplace(key, std::move(timed)).first->second;
}

}  // namespace waystone
