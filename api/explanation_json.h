// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/verdict/explanation.h"

namespace waystone {

// Why an answer is what it is. Fields:
//   image      width, height (px), features
//   gates      min_inliers, min_inlier_share, max_scale, min_probability, ambiguous_share: the
//   limits candidates plane, reference, votes, matches, inliers (at distinct positions), stopped_by
//   (null
//              for a plane that passed), place (null for one that was stopped), points (the inliers
//              as [x_query, y_query, x_reference, y_reference])
//   places     keyframe, planes, inliers, best_share, probability
Json ToJson(const Explanation& explanation);

}  // namespace waystone
