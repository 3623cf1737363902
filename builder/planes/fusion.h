// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/planes/options.h"
#include "schema/map_data.h"

namespace waystone {

// A pair of planes that may be one, and how many descriptor votes say so.
struct FusionCandidate {
  PlaneId m;  // m < n
  PlaneId n;
  int votes = 0;
};

// Pairs that are not covisible (A(m,n) = 0) and whose features look alike, most votes first. Every
// feature votes for the planes of its nearest descriptors, so no pair has to be tried in full.
std::vector<FusionCandidate> ProposeFusions(const std::vector<Plane>& planes,
                                            const std::vector<Edge>& edges, FeatureType type,
                                            const FusionOptions& options);

// Line 17 of Algorithm 1 for one pair: the homography m_from_n between the reference images, when
// enough of the matches support it. Nothing when the planes are not the same.
struct FusionMatch {
  Eigen::Matrix3d m_from_n;
  std::vector<Match> inliers;  // a: feature of m, b: feature of n
};
std::optional<FusionMatch> MatchPlanes(const Plane& m, const Plane& n, FeatureType type,
                                       const PlaneLayerOptions& options);

struct FusionResult {
  std::vector<Plane> planes;  // by id
  std::vector<Edge> edges;    // by (a, b)
  int fused = 0;              // planes that were merged into another
};

// Lines 15 to 19 of Algorithm 1: merges planes that were seen again (eq. 6). The lower id stays,
// the other one's features, views and edges pass to it. A plane that is the same surface but mostly
// out of reach of the other's reference image stays too and gets an edge (identity homology) to it.
// `planes` and `edges` are ordered by id and (a, b). `exhaustive` tries every pair instead of the
// proposed ones: the paper's way, for tests.
FusionResult FusePlanes(std::vector<Plane> planes, std::vector<Edge> edges,
                        const std::vector<Keyframe>& keyframes, FeatureType type,
                        const PlaneLayerOptions& options, bool exhaustive = false);

}  // namespace waystone
