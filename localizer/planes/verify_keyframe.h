// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/features/features.h"
#include "localizer/index/map_index.h"
#include "localizer/planes/plane_query_options.h"
#include "localizer/planes/verify.h"
#include "localizer/verdict/answer.h"

namespace waystone {

// All features of a keyframe that a map stores: those of its planes, mapped there by their
// homographies, and its landmarks.
struct KeyframeFeatures {
  std::vector<Eigen::Vector2d> positions;  // in the keyframe, px
  Descriptors descriptors;                 // row i belongs to positions[i]
  std::vector<int> rows;                   // of MapIndex::search()
};

// Those that lie in the keyframe's image. `keyframe` is an index in the map's keyframes. Pure;
// thread-safe.
KeyframeFeatures CollectKeyframeFeatures(const MapIndex& index, int keyframe);

// A keyframe after the query's matches with it were verified by one epipolar geometry.
struct VerifiedKeyframe {
  int keyframe = 0;  // index in the map's keyframes
  // Inliers, row by row: pixels of the query and of the keyframe.
  std::vector<Eigen::Vector2d> query_points;
  std::vector<Eigen::Vector2d> keyframe_points;
  std::vector<MapMatch> inliers;  // the same as features
  int matches = 0;                // among which they were found
  int distinct = 0;               // inliers at distinct positions of the query
  // Features of the keyframe that, by the inliers, lie where the query can show them (CanShow).
  int expected = 0;
  double coverage = 0;      // as ComputeCoverage has it for the inliers
  int independent = 0;      // inliers that CountIndependent counts, at most all distinct ones
  double significance = 0;  // as EpipolarSignificance has it for the distinct inliers
  // The same for the independent inliers, among as large a share of the matches.
  double independent_significance = 0;
};

// Matches a keyframe with the query (mutually nearest, one to one, with the ratio test against the
// query's features, which are many more) and keeps what fits one epipolar geometry: no inlier when
// nothing fits. Deterministic; thread-safe.
VerifiedKeyframe VerifyKeyframe(const MapIndex& index, const Features& query, int keyframe,
                                const PlaneQueryOptions& options);

}  // namespace waystone
