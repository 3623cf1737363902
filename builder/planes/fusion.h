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

// Lines 15 to 19 of Algorithm 1: merges planes that were seen again (eq. 6). The lower id stays, the
// other one's features, views and edges pass to it. Returns how many were merged.
// `exhaustive` tries every pair instead of the proposed ones: the paper's way, for tests.
int FusePlanes(std::vector<Plane>& planes, std::vector<Edge>& edges, FeatureType type,
               const PlaneLayerOptions& options, bool exhaustive = false);

}  // namespace waystone
