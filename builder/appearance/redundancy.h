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
                    "Largest loss of information by which a panorama may be left out: the share "
                    "of its magnitudes' variance over the map that interpolating between the kept "
                    "panoramas before and after it doesn't explain. 0 keeps all; 0.1 is sparing. "
                    "Even small losses cost accuracy between the nodes."});
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
