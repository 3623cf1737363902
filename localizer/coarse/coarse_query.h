// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/features/features.h"
#include "localizer/appearance/panorama_query_options.h"
#include "localizer/planes/image_features.h"
#include "localizer/planes/plane_query_options.h"

namespace waystone {

// What queries of the entries of one feature type need.
struct CoarseNeed {
  FeatureType type = FeatureType::kSift;
  int working_pixels = 0;  // of the largest keyframe; 0 where all places are panoramas
  bool panoramas = false;  // whether some places are panoramas
};

// Descriptors of one image, of one type.
struct CoarseDescriptors {
  FeatureType type = FeatureType::kSift;
  Descriptors rows;
};

// Describes an image for these entries: by its features, and for a panorama by those of its faces.
// What is extracted stays in `features`, for the maps that are queried next. Deterministic;
// thread-safe for different `features`.
std::vector<CoarseDescriptors> DescribeForCoarse(const cv::Mat& grey,
                                                 const std::vector<CoarseNeed>& needs,
                                                 const PlaneQueryOptions& planes,
                                                 const PanoramaQueryOptions& panorama,
                                                 ImageFeatures& features);

}  // namespace waystone
