// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "builder/planes/fusion_candidates.h"
#include "builder/planes/options.h"
#include "core/features/packed_rows.h"
#include "core/homography/homography.h"
#include "schema/map_data.h"

namespace waystone {

// Line 17 of Algorithm 1 for one pair: the homography m_from_n between the reference images, when
// enough of the matches support it, and nothing otherwise. Callers decide how much of the planes'
// overlap has to match.
struct FusionMatch {
  HomographyEstimate m_from_n;
  std::vector<Match> inliers;  // a: feature of m, b: feature of n
};
// `packed_m` are m's descriptors. Deterministic; thread-safe.
std::optional<FusionMatch> MatchPlanes(const Plane& m, const PackedRows& packed_m, const Plane& n,
                                       const PlaneLayerOptions& options);

struct FusionResult {
  std::vector<Plane> planes;               // by id
  std::vector<Edge> edges;                 // by (a, b)
  int fused = 0;                           // planes that were merged into another
  std::map<PlaneId, PlaneId> merged_into;  // each of them, and the plane that it is now part of
  int joined = 0;                          // pairs that stay and got an edge as one surface
};

// Lines 15 to 19 of Algorithm 1: merges planes that were seen again (eq. 6). The lower id stays,
// and the other plane's features, views and edges pass to it. A plane that is the same surface but
// lies mostly out of reach of the other's reference image, or of what their matches determine, also
// stays and gets an edge (identity homology) to it. In the end the edges between planes that were
// seen together as parts of one surface get the identity, too (JoinSurfaces).
// `planes`, `edges` and `keyframes` are ordered by id and (a, b). Deterministic on any number of
// threads (it uses TBB's).
FusionResult FusePlanes(std::vector<Plane> planes, const std::vector<Edge>& edges,
                        const std::vector<Keyframe>& keyframes, FeatureType type,
                        const PlaneLayerOptions& options);

// The same for the given pairs of planes, which share no edge, instead of those of ProposeFusions;
// the paper tries all.
FusionResult FusePairs(std::vector<Plane> planes, const std::vector<Edge>& edges,
                       const std::vector<Keyframe>& keyframes,
                       const std::vector<FusionCandidate>& pairs, FeatureType type,
                       const PlaneLayerOptions& options);

}  // namespace waystone
