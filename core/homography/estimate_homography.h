// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/homography/find_plane.h"
#include "core/homography/homography.h"

namespace waystone {

// The homographies of the plane that most matches of two (or three) images lie on.
struct PlaneEstimate {
  HomographyEstimate to_from;
  HomographyEstimate reference_from;  // as constructed without a reference
  std::vector<int> inliers;           // rows, ascending
};

// FindPlane among all matches, then RefineHomography over its inliers. Nothing where there is no
// plane or its inliers don't determine the homographies. Deterministic for a seed; thread-safe.
std::optional<PlaneEstimate> EstimateHomography(const MatchedPoints& matches,
                                                const LocalRansacOptions& options, uint64_t seed);

}  // namespace waystone
