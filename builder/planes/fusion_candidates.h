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

// A pair of planes that may be one, and how many descriptor votes say so.
struct FusionCandidate {
  PlaneId m;  // m < n
  PlaneId n;
  int votes = 0;
};

// Pairs that are not covisible (A(m,n) = 0) and whose features look alike, most votes first. Every
// feature votes for the planes of descriptors that are like its own, and more like it than others
// of the map are by chance, so that no pair has to be tried in full. Deterministic on any number of
// threads (it uses TBB's).
std::vector<FusionCandidate> ProposeFusions(const std::vector<Plane>& planes,
                                            const std::vector<Edge>& edges, FeatureType type,
                                            const FusionOptions& options);

// The planes (indices, ascending) whose features look like those of each image, in the same sense,
// with as many votes as fusion asks matches for. Deterministic on any number of threads (it uses
// TBB's).
std::vector<std::vector<int>> ProposeSightings(const std::vector<Plane>& planes,
                                               const std::vector<SampledKeyframe>& images,
                                               FeatureType type, const FusionOptions& options);

// The pairs that share an edge.
std::set<PlanePair> Covisible(const std::vector<Edge>& edges);
PlanePair Ordered(PlaneId a, PlaneId b);

}  // namespace waystone
