// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace waystone {

// What speaks for a place whose keyframe was verified by all its matches.
struct KeyframeEvidence {
  // That its epipolar geometry isn't by chance, as EpipolarSignificance has it: of the distinct
  // inliers, and of those that are independent of each other (CountIndependent).
  double significance = 0;
  double independent_significance = 0;
  // Of the features that should be in the query, those found, by the keyframe or by the place's
  // planes, in [0, 1].
  double found_share = 0;
  double coverage = 0;      // share of the query that is near one that was found, in [0, 1]
  double inlier_share = 0;  // of the keyframe's matches that are inliers, in [0, 1]
};

// A place's probability is a product. One factor is 1 / (1 + e^-significance), which is 1/2 where
// random matches fit one or more geometries as well. The other, q, says whether it is this place
// and not another that shares things with it: log(q / (1 - q)) = intercept + the weighted sum of
// the evidence. There the independent significance counts up to where chance is ruled out: a poster
// has any number of inliers, and may hang on every storey. All of it is evidence for a place, so
// that no weight is below 0.
//
// What is weighed: 1, the independent significance as a share of what rules out chance, the
// logarithm of found_share (and a little), coverage, inlier_share.
using KeyframeFactors = Eigen::Vector<double, 5>;
KeyframeFactors KeyframeFactorsOf(const KeyframeEvidence& evidence);

// The weights of these factors, the intercept first.
using KeyframeVerdictModel = KeyframeFactors;

// The model that holds for any map. It was fitted to rendered buildings (waystone-bench
// look-alikes): asked for their own places, for the same places on another storey that shares
// posters, doors and bare walls, and for other buildings.
const KeyframeVerdictModel& DefaultKeyframeModel();

// The probability that a place with this evidence is the query's, in (0, 1).
double ComputeProbability(const KeyframeEvidence& evidence,
                          const KeyframeVerdictModel& model = DefaultKeyframeModel());

}  // namespace waystone
