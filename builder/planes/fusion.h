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
// enough of the matches support it, and nothing otherwise. How much of what the planes have in
// common has to match is the caller's to say.
struct FusionMatch {
  HomographyEstimate m_from_n;
  std::vector<Match> inliers;  // a: feature of m, b: feature of n
};
// `packed_m` are m's descriptors.
std::optional<FusionMatch> MatchPlanes(const Plane& m, const PackedRows& packed_m, const Plane& n,
                                       const PlaneLayerOptions& options);

struct FusionResult {
  std::vector<Plane> planes;               // by id
  std::vector<Edge> edges;                 // by (a, b)
  int fused = 0;                           // planes that were merged into another
  std::map<PlaneId, PlaneId> merged_into;  // each of them, and the plane that it is part of now
  int joined = 0;                          // pairs that stay and got an edge as one surface
};

// Lines 15 to 19 of Algorithm 1: merges planes that were seen again (eq. 6). The lower id stays,
// the other one's features, views and edges pass to it. A plane that is the same surface but mostly
// out of reach of the other's reference image, or of what the matches between the two determine,
// stays too and gets an edge (identity homology) to it. In the end the edges between planes that
// were seen together as parts of one surface say so, too (JoinSurfaces).
// `planes`, `edges` and `keyframes` are ordered by id and (a, b). Deterministic on any number of
// threads (it uses TBB's).
FusionResult FusePlanes(std::vector<Plane> planes, const std::vector<Edge>& edges,
                        const std::vector<Keyframe>& keyframes, FeatureType type,
                        const PlaneLayerOptions& options);

// The same of these pairs of planes that share no edge, instead of those that ProposeFusions gives;
// the paper tries all.
FusionResult FusePairs(std::vector<Plane> planes, const std::vector<Edge>& edges,
                       const std::vector<Keyframe>& keyframes,
                       const std::vector<FusionCandidate>& pairs, FeatureType type,
                       const PlaneLayerOptions& options);

}  // namespace waystone
