// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/base/options.h"
#include "schema/map_data.h"

namespace waystone {

// The evidence for a place.
struct Evidence {
  int inliers = 0;        // of all its planes, at distinct positions of the query
  double best_share = 0;  // of its best plane's matches that are inliers, in [0, 1]
};

// The probability that a place with this evidence is right, in (0, 1). Pure; thread-safe.
double EstimateProbability(const Evidence& evidence, const VerdictModel& model);

// One place that is known to be right or wrong.
struct VerdictSample {
  Evidence evidence;
  bool right = false;
};

struct FitOptions {
  double intercept_sigma = 5;
  double log_inliers_sigma = 2;
  double inlier_share_sigma = 2;
  int min_samples = 10;

  static constexpr auto Fields(const auto& use) {
    using Self = FitOptions;
    return use(
        OptionField{"intercept_sigma", &Self::intercept_sigma, Above(0), "",
                    "Prior standard deviation of the intercept, around that of the default model. "
                    "Higher values trust small numbers of samples more."},
        OptionField{"log_inliers_sigma", &Self::log_inliers_sigma, Above(0), "",
                    "Prior standard deviation of the coefficient of the logarithm of inliers."},
        OptionField{"inlier_share_sigma", &Self::inlier_share_sigma, Above(0), "",
                    "Prior standard deviation of the coefficient of the inlier ratio."},
        OptionField{
            "min_samples", &Self::min_samples, Closed(1, 10'000), "",
            "With fewer right or fewer wrong samples than this, the default model is used."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The model's most probable coefficients (a logistic regression with a normal prior), so that
// perfectly separable samples don't drive them to infinity. Both classes weigh the same, however
// many samples each has. More inliers and a larger share never count against a place. Too few
// samples give the coefficients of the default model. Deterministic; thread-safe.
VerdictModel FitVerdictModel(std::span<const VerdictSample> samples,
                             const FitOptions& options = {});

}  // namespace waystone
