// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/geometry/pose2.h"
#include "core/panorama/fourier_signature.h"

namespace waystone::bench {

// The odometry of Fernandez et al. (2011) as in the paper, to compare with FollowPanoramas: each
// panorama only against the one before it, turned by the compass of the phases with equal weights
// (sec. III-B), by a step as long as the signatures' distance over k1 magnitudes (eq. 2), along the
// new heading, since its robot looks where it goes (eqs. 3 to 5). k2 is the number of the
// signatures' phases. Poses in the frame of the first, in the unit of eq. (2).
std::vector<Pose2> FollowByPaper(const std::vector<FourierSignature>& signatures, int k1);

}  // namespace waystone::bench
