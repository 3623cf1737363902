// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <utility>

#include "core/features/features.h"
#include "localizer/planes/plane_query_options.h"

namespace waystone {

// How features of queries are extracted (locate.h's QueryFeatureOptions) by what must be known of a
// map: its feature type and how many pixels its largest keyframe has, 0 without one.
FeatureOptions QueryFeatureOptions(FeatureType type, int64_t largest_px,
                                   const PlaneQueryOptions& options);

// Features of one image as they were extracted, so that who asks for them again needn't wait: some
// maps after others, and the coarse index before all. Not thread-safe.
class ImageFeatures {
 public:
  struct Timed {
    Features features;
    double ms = 0;  // that their extraction took
  };

  // Of the image, which is the same at each call. Feature type and working pixels tell options
  // apart; the others are the same at each call.
  const Timed& Extract(const cv::Mat& grey, const FeatureOptions& how);

 private:
  std::map<std::pair<FeatureType, int>, Timed> extracted_;
};

}  // namespace waystone
