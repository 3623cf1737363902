// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/keyframe_verdict.h"

#include <algorithm>
#include <cmath>

#include "localizer/verdict/logistic_fit.h"

namespace waystone {

const KeyframeVerdictModel& DefaultKeyframeModel() {
  static constexpr KeyframeVerdictModel kModel{.intercept = -16.6,
                                               .log_inliers = 5,
                                               .found_share = 12,
                                               .coverage = 8,
                                               .planes_log_odds = 0.5};
  return kModel;
}

double LimitPlanesLogOdds(double probability) {
  constexpr double kLargest = 8;
  if (probability <= 0.5) return 0;
  return std::min(kLargest, std::log(probability / std::max(1 - probability, 1e-9)));
}

Eigen::VectorXd KeyframeFactors(const KeyframeEvidence& evidence) {
  Eigen::VectorXd factors(5);
  factors << 1, std::log1p(evidence.inliers), evidence.found_share, evidence.coverage,
      evidence.planes_log_odds;
  return factors;
}

double ComputeProbability(const KeyframeEvidence& evidence, const KeyframeVerdictModel& model) {
  Eigen::VectorXd weights(5);
  weights << model.intercept, model.log_inliers, model.found_share, model.coverage,
      model.planes_log_odds;
  return Logistic(weights.dot(KeyframeFactors(evidence)));
}

}  // namespace waystone
