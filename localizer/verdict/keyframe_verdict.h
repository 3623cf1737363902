// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace waystone {

// What speaks for a place whose keyframe was verified by all its matches.
struct KeyframeEvidence {
  // At distinct positions of the query: of the epipolar geometry or of the place's planes,
  // whichever are more. Planes recognise a surface from farther aside.
  int inliers = 0;
  double found_share = 0;   // of the features that should be in the query, those found, in [0, 1]
  double coverage = 0;      // share of the query's cells that have an inlier, in [0, 1]
  double inlier_share = 0;  // of the keyframe's matches that are inliers, in [0, 1]
};

// log(p / (1 - p)) = intercept + the weighted sum of log(1 + inliers) and of the shares. Each is
// evidence for a place, so that no weight is below 0.
struct KeyframeVerdictModel {
  double intercept = 0;
  double log_inliers = 0;
  double found_share = 0;
  double coverage = 0;
  double inlier_share = 0;
};

// The model that holds for any map. It was fitted to rendered buildings (waystone-bench
// look-alikes): asked for their own places, for the same places on another storey that shares
// posters, doors and bare walls, and for other buildings.
const KeyframeVerdictModel& DefaultKeyframeModel();

// 1, log(1 + inliers), found_share, coverage, inlier_share: what the model's coefficients weigh.
Eigen::VectorXd KeyframeFactors(const KeyframeEvidence& evidence);

// The probability that a place with this evidence is the query's, in (0, 1).
double ComputeProbability(const KeyframeEvidence& evidence,
                          const KeyframeVerdictModel& model = DefaultKeyframeModel());

// The probability of a place whose planes alone give it `by_planes` (0 without planes) and whose
// keyframe gives it `by_keyframe`: either suffices, unless the keyframe speaks against the place.
double JoinProbabilities(double by_planes, double by_keyframe);

}  // namespace waystone
