// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/base/options.h"
#include "localizer/appearance/panorama_features.h"
#include "localizer/index/node_bearings.h"

namespace waystone {

// Which features of a panorama are kept for verifying answers.
struct NodeFeatureOptions {
  int max_kept = 255;
  int sectors = 16;
  double max_crowd = 2;
  PanoramaFeatureOptions extract;
  // Of a panorama's features with those of the one before it.
  MatchOptions match{0.8, true};

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_kept", &NodeFeatureOptions::max_kept, Closed(0, 10'000), "",
                    "Number of features stored per panorama. More features allow verification from "
                    "farther away, at 36 bytes each in the map. With 0, none are stored, and "
                    "answers rely on appearance alone."},
        OptionField{"sectors", &NodeFeatureOptions::sectors, Closed(1, 360), "",
                    "Number of sectors around the horizon, both above and below it, over which "
                    "features are spread.",
                    OptionUse::kInternal},
        OptionField{"max_crowd", &NodeFeatureOptions::max_crowd, Closed(1, 1000), "",
                    "A sector is filled beyond this multiple of its even share only when the other "
                    "sectors have no more features.",
                    OptionUse::kInternal},
        OptionGroup{"extract", &NodeFeatureOptions::extract},
        OptionGroup{"match", &NodeFeatureOptions::match});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Chooses among the features of a sequence's panoramas, one panorama after the other: those that
// were found again in the panoramas before and after are worth keeping, since a query is likely to
// find them too. Among equals the strongest, spread around the horizon. Holds one panorama's
// features at a time. Not thread-safe. Deterministic.
class NodeFeatureChooser {
 public:
  explicit NodeFeatureChooser(const NodeFeatureOptions& options) : options_(options) {}

  // The next panorama of the sequence, which may have no features. Gives what is kept of the one
  // before it; nothing for the first.
  NodeFeatures Next(BearingFeatures features);
  // What is kept of the last panorama. The next one begins another sequence.
  NodeFeatures Last();

 private:
  NodeFeatures Chosen() const;

  const NodeFeatureOptions& options_;
  BearingFeatures features_;  // of the panorama that was added last
  std::vector<int> found_;    // how often each of them was found again
};

}  // namespace waystone
