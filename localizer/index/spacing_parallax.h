// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/options.h"
#include "core/two_view/bearings.h"
#include "core/two_view/relative_rotation.h"
#include "schema/layers/appearance/appearance_layer.h"

namespace waystone {

struct SpacingParallaxOptions {
  int pairs = 16;
  int max_apart = 30;
  MatchOptions match{0.8, true};
  RelativeOptions relative{.max_samples = 200};

  static constexpr auto Fields(const auto& use) {
    using Self = SpacingParallaxOptions;
    return use(
        OptionField{"pairs", &Self::pairs, Closed(1, 1000), "",
                    "Number of pairs of nodes that are matched, spread evenly over the layer.",
                    OptionUse::kInternal},
        OptionField{"max_apart", &Self::max_apart, Closed(1, 10'000), "nodes",
                    "The nodes of a pair are at most this many nodes apart, over which odometry "
                    "hardly drifts.",
                    OptionUse::kInternal},
        OptionGroup{"match", &Self::match}, OptionGroup{"relative", &Self::relative});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Median angle between a node's and the query's rays to the same point, after removing the
// rotation; 0 for a pose without inliers. Pure; thread-safe.
double MedianParallax(const MatchedRays& rays, const RelativePose& pose);

// The median parallax (rad) of two panoramas a `spacing` (layer's units) apart, measured on the
// layer's own nodes: it depends on how large the rooms are in spacings, and positions are estimated
// from a query's parallax with it. 0 where no pair has an accepted motion, for instance without
// features. Takes a few ms per pair. Deterministic on any number of threads (it uses TBB's);
// thread-safe.
double MeasureSpacingParallax(const AppearanceLayer& layer, FeatureType type, double spacing,
                              const SpacingParallaxOptions& options = {});

}  // namespace waystone
