// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/keyframe_verdict.h"

#include <algorithm>
#include <cmath>

#include "localizer/verdict/logistic_fit.h"

namespace waystone {

const KeyframeVerdictModel& DefaultKeyframeModel() {
  static constexpr KeyframeVerdictModel kModel{.intercept = -14.994,
                                               .log_inliers = 3.876,
                                               .found_share = 7.007,
                                               .coverage = 1.254,
                                               .inlier_share = 3.625};
  return kModel;
}

Eigen::VectorXd KeyframeFactors(const KeyframeEvidence& evidence) {
  Eigen::VectorXd factors(5);
  factors << 1, std::log1p(evidence.inliers), evidence.found_share, evidence.coverage,
      evidence.inlier_share;
  return factors;
}

double ComputeProbability(const KeyframeEvidence& evidence, const KeyframeVerdictModel& model) {
  Eigen::VectorXd weights(5);
  weights << model.intercept, model.log_inliers, model.found_share, model.coverage,
      model.inlier_share;
  return Logistic(weights.dot(KeyframeFactors(evidence)));
}

double JoinProbabilities(double by_planes, double by_keyframe) {
  constexpr double kEven = 0.5;
  return by_keyframe < kEven ? by_keyframe : std::max(by_planes, by_keyframe);
}

}  // namespace waystone
