// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <utility>

#include "core/features/features.h"
#include "localizer/planes/plane_query_options.h"

namespace waystone {

// How features of queries are extracted (locate.h's QueryFeatureOptions), by what matters about a
// map: its feature type and how many pixels its largest keyframe has, 0 without one. Pure;
// thread-safe.
FeatureOptions QueryFeatureOptions(FeatureType type, int64_t largest_px,
                                   const PlaneQueryOptions& options);

// A cache of the features of one image, for queries of several maps and of the coarse index before
// them. Not thread-safe.
class ImageFeatures {
 public:
  struct Timed {
    Features features;
    double ms = 0;  // that their extraction took
  };

  // The features of the image, which is the same at each call. Only feature type and working pixels
  // may differ between calls.
  const Timed& Extract(const cv::Mat& grey, const FeatureOptions& how);

 private:
  std::map<std::pair<FeatureType, int>, Timed> extracted_;
};

}  // namespace waystone
