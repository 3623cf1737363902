// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/loop_closure.h"
#include "core/base/options.h"

namespace waystone {

// Which panoramas are left out of the map.
struct RedundancyOptions {
  double max_loss = 0;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_loss", &RedundancyOptions::max_loss, Closed(0, 1), "",
                    "Maximum loss of information at which a panorama may be left out: the share of "
                    "its magnitudes' variance over the map that isn't explained by interpolating "
                    "between the kept panoramas before and after it. 0 keeps all panoramas; 0.1 "
                    "leaves out few. Even small losses cost accuracy between the nodes."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Which panoramas of the stretches are kept; the ends of each stretch always are. Greedy along the
// way: leaves out as many in a row as can be interpolated with a loss of at most max_loss each.
// `poses` give the trajectory. Pure; thread-safe.
std::vector<bool> KeepInformative(const std::vector<FourierSignature>& signatures,
                                  const std::vector<Pose2>& poses,
                                  const std::vector<PanoramaStretch>& stretches,
                                  const RedundancyOptions& options = {});

}  // namespace waystone
