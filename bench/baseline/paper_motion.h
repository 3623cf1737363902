// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/two_view/bearings.h"
#include "core/two_view/five_point.h"

namespace waystone::bench {

struct PaperMotion {
  Motion motion;
  std::vector<int> inliers;
};

// The motion between two places as Rituerto et al. (2011) take it from Hartley and Zisserman (sec.
// II-B): the essential matrix by RANSAC over samples of eight rays, fitted once more to its inliers
// by the same linear equations, without refining the motion; of its four motions the one with the
// most points ahead. Nothing with fewer than `min_inliers` inliers (the paper's threshold, sec.
// III-C).
std::optional<PaperMotion> FindMotionByEightPoints(const MatchedRays& rays,
                                                   double max_error_rad = 0.003,
                                                   int min_inliers = 10, int max_samples = 2000,
                                                   uint64_t seed = 1);

}  // namespace waystone::bench
