// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "core/base/options.h"
#include "core/two_view/bearings.h"

namespace waystone {

struct PanoramaFeatureOptions {
  // Features of each face, and how they are spread over it.
  BearingFeatureOptions bearings{.features = {.max_features = 600, .contrast_threshold = 0.02},
                                 .max_kept = 300};
  double face_width = 0.318;

  static constexpr auto Fields(const auto& use) {
    return use(OptionGroup{"bearings", &PanoramaFeatureOptions::bearings},
               OptionField{"face_width", &PanoramaFeatureOptions::face_width, Closed(0.05, 1), "",
                           "Width of a face relative to the panorama's. A face covers a quarter of "
                           "the circle; at 1 / pi its centre has the panorama's resolution. Lower "
                           "values are faster, but find fewer features."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Features of a whole equirectangular panorama (CV_8UC1), taken from its front, right, back and
// left faces, where lines are straight; rays in the rig's frame (x right, y down, z forward =
// front). Both panoramas of a comparison should be taken with the same options. Deterministic;
// thread-safe. Throws MapError(kBadImage) for an image that isn't exactly twice as wide as high.
BearingFeatures ExtractPanoramaFeatures(const cv::Mat& equirectangular,
                                        const PanoramaFeatureOptions& options = {});

// The same of a panorama that is a little narrower or wider (HasPanoramaShape), which is scaled to
// the shape first.
BearingFeatures ExtractScaledPanorama(const cv::Mat& grey,
                                      const PanoramaFeatureOptions& options = {});

}  // namespace waystone
