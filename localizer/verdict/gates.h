// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/options.h"

namespace waystone {

// The gates between a shortlisted plane and an answer.
struct GateOptions {
  int min_inliers = 8;
  double min_probability = 0.9;
  double min_inlier_share = 0.2;
  double distinct_px = 4.0;
  double max_scale = 8.0;
  double ambiguous_share = 0.7;
  double min_rival_probability = 0.2;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"min_inliers", &GateOptions::min_inliers, AtLeast(5), "",
                    "Minimum number of distinct image positions whose matches must support a "
                    "plane's homography. Higher values refuse more true planes; lower values "
                    "accept more planes by chance."},
        OptionField{"min_probability", &GateOptions::min_probability, Open(0, 1), "",
                    "Minimum probability, by the map's model, of a localized answer. Higher values "
                    "refuse more queries."},
        OptionField{"min_inlier_share", &GateOptions::min_inlier_share, Closed(0, 1), "",
                    "Minimum share of the plane's matches that must support its homography. Higher "
                    "values refuse more true planes."},
        OptionField{"distinct_px", &GateOptions::distinct_px, AtLeast(0), "px",
                    "Inliers closer together than this count as one, since a single corner gives "
                    "several features."},
        OptionField{"max_scale", &GateOptions::max_scale, Above(1), "",
                    "Maximum factor by which a homography may enlarge or shrink the query, "
                    "relative to the sizes of both images. Larger factors are fits to noise."},
        OptionField{"ambiguous_share", &GateOptions::ambiguous_share, OpenLow(0, 1), "",
                    "If either place is recognised by its planes alone, an answer is ambiguous if "
                    "the second place has at least this share of the first one's inliers. Lower "
                    "values make more answers ambiguous."},
        OptionField{"min_rival_probability", &GateOptions::min_rival_probability, Closed(0, 1), "",
                    "Minimum probability of a second place recognised by a keyframe, since an "
                    "epipolar geometry fits some matches of any two images.",
                    OptionUse::kInternal});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
