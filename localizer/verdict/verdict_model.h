// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "schema/map_data.h"

namespace waystone {

// What speaks for a place.
struct Evidence {
  int inliers = 0;        // of all its planes, at distinct positions of the query
  double best_share = 0;  // of its best plane's matches that are inliers, in [0, 1]
};

// The probability that a place with this evidence is right, in (0, 1).
double ProbabilityOf(const Evidence& evidence, const VerdictModel& model);

// One place of which it is known whether it was right.
struct VerdictSample {
  Evidence evidence;
  bool right = false;
};

struct FitOptions {
  // Standard sigmas of the model's coefficients around those of the model that holds for any
  // map. Larger ones trust few samples more.
  double intercept_sigma = 5;
  double log_inliers_sigma = 2;
  double inlier_share_sigma = 2;

  void Check() const;  // throws MapError(kBadOptions)
};

// The model's most probable coefficients (a logistic regression with a normal prior), so that
// samples which are told apart without an error don't drive them to infinity. The two classes weigh
// the same, however many samples each has. Deterministic.
VerdictModel FitVerdictModel(std::span<const VerdictSample> samples,
                             const FitOptions& options = {});

}  // namespace waystone
