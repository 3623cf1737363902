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
  static constexpr KeyframeVerdictModel kModel{.intercept = -2.572,
                                               .significance = 2.685,
                                               .found_share = 1.324,
                                               .coverage = 4.771,
                                               .inlier_share = 3.252,
                                               .surfaces = 0.125};
  return kModel;
}

Eigen::VectorXd KeyframeFactors(const KeyframeEvidence& evidence) {
  Eigen::VectorXd factors(6);
  factors << 1, std::min(1.0, evidence.significance / kNoChance),
      std::log(kShareByChance + evidence.found_share), evidence.coverage, evidence.inlier_share,
      evidence.surfaces;
  return factors;
}

double ComputeProbability(const KeyframeEvidence& evidence, const KeyframeVerdictModel& model) {
  Eigen::VectorXd weights(6);
  weights << model.intercept, model.significance, model.found_share, model.coverage,
      model.inlier_share, model.surfaces;
  return Logistic(weights.dot(KeyframeFactors(evidence)));
}

}  // namespace waystone
