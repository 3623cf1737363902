// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/options.h"
#include "core/camera_pose/absolute_pose.h"

namespace waystone {

// How the pose of a localized query is estimated on a map with poses.
struct PoseQueryOptions {
  double keypoint_sigma_px = 0.7;
  int keyframes = 6;
  double search_px = 5;
  double max_descriptor_distance = 0.4;
  AbsolutePoseOptions solve;

  static constexpr auto Fields(const auto& use) {
    using Self = PoseQueryOptions;
    return use(
        OptionField{"keypoint_sigma_px", &Self::keypoint_sigma_px, Above(0), "px",
                    "Standard deviation of a keypoint's position.", OptionUse::kInternal},
        OptionField{
            "keyframes", &Self::keyframes, AtLeast(0), "",
            "Number of keyframes nearest to an initial pose whose features are searched for in the "
            "query where that pose projects them. More keyframes are more accurate, but slower.",
            OptionUse::kInternal},
        OptionField{"search_px", &Self::search_px, Above(0), "px",
                    "Search radius around the projected position of a feature.",
                    OptionUse::kInternal},
        OptionField{"max_descriptor_distance", &Self::max_descriptor_distance, OpenLow(0, 1), "",
                    "Maximum distance between their descriptors, as a share of the largest "
                    "possible distance.",
                    OptionUse::kInternal},
        OptionGroup{"solve", &Self::solve});
  }
};

}  // namespace waystone
