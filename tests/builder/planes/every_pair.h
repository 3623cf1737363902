// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <vector>

#include "builder/planes/fusion_candidates.h"

namespace waystone {

// Every pair of planes that share no edge: what the paper tries to fuse.
inline std::vector<FusionCandidate> EveryPair(const std::vector<Plane>& planes,
                                              const std::vector<Edge>& edges) {
  const std::set<PlanePair> covisible = Covisible(edges);
  std::vector<FusionCandidate> candidates;
  for (size_t m = 0; m < planes.size(); ++m) {
    for (size_t n = m + 1; n < planes.size(); ++n) {
      if (!covisible.contains({planes[m].id, planes[n].id})) {
        candidates.push_back({planes[m].id, planes[n].id, 0});
      }
    }
  }
  return candidates;
}

}  // namespace waystone
