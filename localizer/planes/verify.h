// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/homography/homography.h"
#include "localizer/index/map_index.h"
#include "localizer/planes/plane_query_options.h"
#include "localizer/planes/shortlist.h"
#include "localizer/verdict/deadline.h"
#include "localizer/verdict/explanation.h"

namespace waystone {

// A shortlisted plane after its homography was tried.
struct VerifiedPlane {
  int plane = 0;  // index in the map's planes
  HomographyEstimate reference_from_query;
  std::vector<Match> inliers;             // a: query keypoint, b: feature of the plane
  int matches = 0;                        // in which the homography was searched
  int distinct = 0;                       // inliers at distinct positions of the query
  bool accepted = false;                  // passed the plane's gates
  Gate stopped_by = Gate::kNoHomography;  // the first gate that it failed; kPassed when accepted
};

// A query's features, packed once for all planes that they are matched with.
struct PackedFeatures {
  explicit PackedFeatures(const Features& query)
      : features(query), rows(query.type, query.descriptors) {}

  const Features& features;
  PackedRows rows;
};

// The homography between a query and one plane by RANSAC, with its acceptance test. Nothing when
// there is no homography at all. Deterministic; thread-safe, as all functions here (TryPlanes up to
// its deadline).
std::optional<VerifiedPlane> VerifyPlane(const MapIndex& index, const PackedFeatures& query,
                                         int plane, const PlaneQueryOptions& options);

// Whether it is pointless to try a candidate, since another plane has settled where the query is.
bool IsBeaten(const MapIndex& index, const ShortlistedPlane& candidate, const VerifiedPlane& best,
              const PlaneQueryOptions& options);

// Estimates the homographies of the shortlisted planes, in their order, until the deadline. Planes
// elsewhere are skipped once one has settled where the query is
// (PlaneQueryOptions::settled_inliers).
std::vector<VerifiedPlane> TryPlanes(const MapIndex& index, const Features& query,
                                     const std::vector<ShortlistedPlane>& shortlist,
                                     const PlaneQueryOptions& options,
                                     const Deadline& deadline = {});

// Whether two recognised planes agree: seen together in a keyframe, the homographies from the query
// to that keyframe through either plane must form a valid homology (sec. II-B). Nothing when no
// keyframe saw both and they can't be compared.
std::optional<bool> PlanesAgree(const MapIndex& index, const VerifiedPlane& m,
                                const VerifiedPlane& n, const PlaneQueryOptions& options);

}  // namespace waystone
