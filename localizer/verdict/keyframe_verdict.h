// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace waystone {

// The evidence for a place whose keyframe was verified by all its matches.
struct KeyframeEvidence {
  // How unlikely its epipolar geometry is by chance (EpipolarSignificance): for the distinct
  // inliers, and for those that are independent of each other (CountIndependent).
  double significance = 0;
  double independent_significance = 0;
  // Share of the features that should be in the query that were found, by the keyframe or by the
  // place's planes, in [0, 1].
  double found_share = 0;
  double coverage = 0;      // share of the query that is near one that was found, in [0, 1]
  double inlier_share = 0;  // of the keyframe's matches that are inliers, in [0, 1]
};

// A place's probability is a product. One factor is 1 / (1 + e^-significance), which is 1/2 where
// random matches fit one or more geometries as well. The other, q, is the probability of this place
// rather than another one that shares things with it: log(q / (1 - q)) = intercept + the weighted
// sum of the evidence. There the independent significance is capped where chance is ruled out: a
// poster may have any number of inliers and hang on every storey. Everything is evidence for a
// place, so no weight is below 0.
//
// The factors: 1, the independent significance as a share of what rules out chance, the logarithm
// of found_share (plus a small constant), coverage, inlier_share.
using KeyframeFactors = Eigen::Vector<double, 5>;
// Pure; thread-safe, as all functions here.
KeyframeFactors KeyframeFactorsOf(const KeyframeEvidence& evidence);

// The weights of these factors, the intercept first.
using KeyframeVerdictModel = KeyframeFactors;

// The model that holds for any map. It was fitted to rendered buildings (waystone-bench
// look-alikes): queried with their own places, with the same places on another storey that shares
// posters, doors and bare walls, and with other buildings.
const KeyframeVerdictModel& DefaultKeyframeModel();

// The probability that a place with this evidence is the query's, in (0, 1).
double ComputeProbability(const KeyframeEvidence& evidence,
                          const KeyframeVerdictModel& model = DefaultKeyframeModel());

}  // namespace waystone
