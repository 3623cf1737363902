// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tuple>

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

  static constexpr auto Fields() {
    return std::tuple{
        OptionField{"min_inliers", &GateOptions::min_inliers, AtLeast(5), "",
                    "Distinct places in the image whose matches support a plane's homography. "
                    "Higher refuses more true planes, lower lets chance through."},
        OptionField{"min_probability", &GateOptions::min_probability, Open(0, 1), "",
                    "Probability that a place is right, by the map's model, from which on the "
                    "answer is localized. Higher refuses more."},
        OptionField{"min_inlier_share", &GateOptions::min_inlier_share, Closed(0, 1), "",
                    "Share of the plane's matches that must support its homography. Higher refuses "
                    "more true planes."},
        OptionField{"distinct_px", &GateOptions::distinct_px, AtLeast(0), "px",
                    "Inliers closer together than this count once: one corner gives several "
                    "features."},
        OptionField{"max_scale", &GateOptions::max_scale, Above(1), "",
                    "Largest factor by which a homography may enlarge or shrink between query and "
                    "reference, relative to the sizes of both images. A larger one is a fit "
                    "through noise."},
        OptionField{"ambiguous_share", &GateOptions::ambiguous_share, OpenLow(0, 1), "",
                    "A second place with this share of the first one's inliers makes the answer "
                    "ambiguous. Lower calls more answers ambiguous."},
        OptionField{"min_rival_probability", &GateOptions::min_rival_probability, Closed(0, 1), "",
                    "A second place that is known by a keyframe alone must have this probability "
                    "as well: an epipolar geometry fits some matches of any two images.",
                    OptionUse::kInternal}};
  }
  void Check() const { CheckFields("gates", *this); }  // throws MapError(kBadOptions)
};

}  // namespace waystone
