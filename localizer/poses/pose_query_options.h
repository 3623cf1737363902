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
        OptionField{"keyframes", &Self::keyframes, AtLeast(0), "",
                    "Keyframes nearest to a first pose whose features are searched for in the "
                    "query where it puts them. More are more accurate and slower.",
                    OptionUse::kInternal},
        OptionField{"search_px", &Self::search_px, Above(0), "px",
                    "How far from there they are searched for.", OptionUse::kInternal},
        OptionField{"max_descriptor_distance", &Self::max_descriptor_distance, OpenLow(0, 1), "",
                    "Largest distance of their descriptors, as a share of what descriptors can "
                    "differ by.",
                    OptionUse::kInternal},
        OptionGroup{"solve", &Self::solve});
  }
};

}  // namespace waystone
