// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/loop_closure.h"

namespace waystone {

struct RedundancyOptions {
  // Largest loss of information by which a panorama may be left out of the map, 0 to 1: the share
  // of its magnitudes' variance over the map that those of the kept panoramas before and after it,
  // interpolated by the way, don't give. 0 keeps all: even small losses cost localization between
  // the nodes some of its accuracy. 0.1 is sparing.
  double max_loss = 0;

  void Check() const;  // throws MapError(kBadOptions)
};

// Which panoramas of the stretches are kept; the ends of each stretch always are. Greedy along the
// way: as many in a row are left out as all lose max_loss at most. `poses` give the trajectory.
std::vector<bool> KeepInformative(const std::vector<FourierSignature>& signatures,
                                  const std::vector<Pose2>& poses,
                                  const std::vector<PanoramaStretch>& stretches,
                                  const RedundancyOptions& options = {});

}  // namespace waystone
