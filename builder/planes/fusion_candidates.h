// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "builder/planes/keyframe_sample.h"
#include "builder/planes/options.h"
#include "schema/map_data.h"

namespace waystone {

using PlanePair = std::pair<PlaneId, PlaneId>;  // the lower id first

// A pair of planes that may be the same, and the number of descriptor votes for it.
struct FusionCandidate {
  PlaneId m;  // m < n
  PlaneId n;
  int votes = 0;
};

// Pairs that are not covisible (A(m,n) = 0) and whose features look alike, most votes first. Every
// feature votes for the planes of descriptors that are similar to its own, and more so than others
// of the map are by chance, so that not every pair has to be matched. Deterministic on any number
// of threads (it uses TBB's).
std::vector<FusionCandidate> ProposeFusions(const std::vector<Plane>& planes,
                                            const std::vector<Edge>& edges, FeatureType type,
                                            const FusionOptions& options);

// For each image, the planes (indices, ascending) whose features look like its own, by the same
// kind of votes, with at least as many votes as fusion requires matches. Deterministic on any
// number of threads (it uses TBB's).
std::vector<std::vector<int>> ProposeSightings(const std::vector<Plane>& planes,
                                               const std::vector<SampledKeyframe>& images,
                                               FeatureType type, const FusionOptions& options);

// The pairs that share an edge. Pure; thread-safe, as is the next.
std::set<PlanePair> Covisible(const std::vector<Edge>& edges);
PlanePair Ordered(PlaneId a, PlaneId b);

}  // namespace waystone
