// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "core/base/options.h"
#include "core/manhattan/manhattan_frame.h"

namespace waystone {

// How a query's rotation in the building is estimated and checked.
struct BuildingOptions {
  SegmentOptions segments;
  GreatCircleOptions circles;
  ManhattanOptions manhattan;
  double max_clear_rival = 0.6;
  double max_disagreement_rad = 0.17;
  double true_disagreeing = 0.02;
  double min_plane_sigma_rad = 0.003;
  int working_pixels = 4'000'000;

  static constexpr auto Fields(const auto& use) {
    using Self = BuildingOptions;
    return use(
        OptionGroup{"segments", &Self::segments}, OptionGroup{"circles", &Self::circles},
        OptionGroup{"manhattan", &Self::manhattan},
        OptionField{
            "max_clear_rival", &Self::max_clear_rival, Closed(0, 1), "",
            "The query's lines are accepted if their best rival frame has at most this share of "
            "their support. Higher values accept more photos, but also more wrong frames."},
        OptionField{"max_disagreement_rad", &Self::max_disagreement_rad,
                    Open(0, std::numbers::pi / 4), "rad",
                    "Maximum angle between accepted lines and the axes that a place implies. "
                    "Higher values let more wrong places pass."},
        OptionField{"true_disagreeing", &Self::true_disagreeing, Open(0, 1), "",
                    "Share of true places whose accepted lines disagree nevertheless. Higher "
                    "values refuse fewer answers."},
        OptionField{"min_plane_sigma_rad", &Self::min_plane_sigma_rad, Above(0), "rad",
                    "Minimum standard deviation of a rotation estimated from a recognised plane, "
                    "due to calibration and the keyframe's own axes.",
                    OptionUse::kInternal},
        OptionField{"working_pixels", &Self::working_pixels, Closed(10'000, 50'000'000), "",
                    "Larger photos, and panoramas whose faces are larger in total, are downscaled "
                    "to this many pixels before line detection, which bounds time and memory.",
                    OptionUse::kInternal});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
