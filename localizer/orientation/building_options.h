// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <tuple>

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
  int working_pixels = 4'000'000;

  static constexpr auto Fields() {
    using Self = BuildingOptions;
    return std::tuple{
        OptionGroup{"segments", &Self::segments},
        OptionGroup{"circles", &Self::circles},
        OptionGroup{"manhattan", &Self::manhattan},
        OptionField{"max_clear_rival", &Self::max_clear_rival, Closed(0, 1), "",
                    "The query's lines are believed when their best rival frame has at most this "
                    "share of their support. Higher believes more photos, and more that are "
                    "wrong."},
        OptionField{
            "max_disagreement_rad", &Self::max_disagreement_rad, Open(0, std::numbers::pi / 4),
            "rad",
            "Angle by which believed lines may be off the axes that a place implies. Higher "
            "lets more wrong places pass."},
        OptionField{"true_disagreeing", &Self::true_disagreeing, Open(0, 1), "",
                    "Share of true places whose lines are believed and disagree all the same. "
                    "Higher refuses fewer answers."},
        OptionField{"working_pixels", &Self::working_pixels, Closed(10'000, 50'000'000), "",
                    "Larger photos, and larger faces of a panorama together, are reduced to so "
                    "many pixels before their lines are detected, which bounds time and memory.",
                    OptionUse::kInternal}};
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
