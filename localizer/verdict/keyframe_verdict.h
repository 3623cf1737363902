// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace waystone {

// What speaks for a keyframe that was verified by all its matches.
struct KeyframeEvidence {
  int inliers = 0;         // of one epipolar geometry, at distinct positions of the query
  double found_share = 0;  // of the features that should be in the query, those found, in [0, 1]
  double coverage = 0;     // share of the query's cells that have an inlier, in [0, 1]
  // log(p / (1 - p)) of the probability that the place's planes alone give it; 0 where that is
  // below even and for a place without planes.
  double planes_log_odds = 0;
};

// The planes' log-odds as evidence beside a keyframe's: between 0 and 8, so that no count of a
// poster's inliers outweighs all that is missing around it.
double LimitPlanesLogOdds(double probability);

// log(p / (1 - p)) = intercept + the weighted sum of log(1 + inliers), of the shares and of the
// planes' log-odds. Each is evidence for a place, so that no weight is below 0.
struct KeyframeVerdictModel {
  double intercept = 0;
  double log_inliers = 0;
  double found_share = 0;
  double coverage = 0;
  double planes_log_odds = 0;
};

// The model that holds for any map. It was fitted to rendered buildings (waystone-bench
// look-alikes): asked for their own places, for the same places on another storey that shares
// posters, doors and bare walls, and for other buildings.
const KeyframeVerdictModel& DefaultKeyframeModel();

// 1, log(1 + inliers), found_share, coverage, planes_log_odds: what the model's coefficients weigh.
Eigen::VectorXd KeyframeFactors(const KeyframeEvidence& evidence);

// The probability that a keyframe with this evidence shows the query's place, in (0, 1).
double ComputeProbability(const KeyframeEvidence& evidence,
                          const KeyframeVerdictModel& model = DefaultKeyframeModel());

}  // namespace waystone
