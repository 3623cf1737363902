// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// What speaks for a keyframe that was verified by all its matches.
struct KeyframeEvidence {
  int inliers = 0;         // of one epipolar geometry, at distinct positions of the query
  double found_share = 0;  // of the features that should be in the query, those found, in [0, 1]
  double coverage = 0;     // share of the query's cells that have an inlier, in [0, 1]
};

// log(p / (1 - p)) = intercept + the weighted sum of log(1 + inliers) and of the shares. Each is
// evidence for a place, so that no weight is below 0. The defaults hold for any map: a few inliers
// suffice where most of what should be in the query is there, and hallways that share doors and
// posters, with 17 inliers of 100 features, aren't one place.
struct KeyframeVerdictModel {
  double intercept = -16.6;
  double log_inliers = 5;
  double found_share = 12;
  double coverage = 8;
};

// The probability that a keyframe with this evidence shows the query's place, in (0, 1).
double ComputeProbability(const KeyframeEvidence& evidence, const KeyframeVerdictModel& model = {});

// The probability that a place is right which its planes call right with `by_planes` and its
// keyframe with `by_keyframe`. Features that should be in the query and aren't speak against the
// planes, too: a poster on another floor has all the planes' inliers and little else.
double JoinProbabilities(double by_planes, double by_keyframe, const KeyframeEvidence& evidence);

}  // namespace waystone
