// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/keyframe_verdict.h"

#include <algorithm>
#include <cmath>

#include "localizer/verdict/logistic_fit.h"

namespace waystone {
namespace {

constexpr double kNoChance = 10;         // one false alarm in e^10 keyframes
constexpr double kShareByChance = 0.05;  // of a keyframe's features, found where none should be

}  // namespace

const KeyframeVerdictModel& DefaultKeyframeModel() {
  static constexpr KeyframeVerdictModel kModel{.intercept = -3.488,
                                               .independent_significance = 1.495,
                                               .found_share = 2.402,
                                               .coverage = 14.999,
                                               .inlier_share = 6.116};
  return kModel;
}

Eigen::VectorXd KeyframeFactors(const KeyframeEvidence& evidence) {
  Eigen::VectorXd factors(5);
  factors << 1, std::min(1.0, evidence.independent_significance / kNoChance),
      std::log(kShareByChance + evidence.found_share), evidence.coverage, evidence.inlier_share;
  return factors;
}

KeyframeVerdictModel KeyframeModelOf(const Eigen::VectorXd& coefficients) {
  return {.intercept = coefficients(0),
          .independent_significance = coefficients(1),
          .found_share = coefficients(2),
          .coverage = coefficients(3),
          .inlier_share = coefficients(4)};
}

double ComputeProbability(const KeyframeEvidence& evidence, const KeyframeVerdictModel& model) {
  Eigen::VectorXd coefficients(5);
  coefficients << model.intercept, model.independent_significance, model.found_share,
      model.coverage, model.inlier_share;
  return Logistic(evidence.significance) * Logistic(coefficients.dot(KeyframeFactors(evidence)));
}

}  // namespace waystone
