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

KeyframeFactors KeyframeFactorsOf(const KeyframeEvidence& evidence) {
  return {1, std::min(1.0, evidence.independent_significance / kNoChance),
          std::log(kShareByChance + evidence.found_share), evidence.coverage,
          evidence.inlier_share};
}

const KeyframeVerdictModel& DefaultKeyframeModel() {
  static const KeyframeVerdictModel kModel(-3.488, 1.495, 2.402, 14.999, 6.116);
  return kModel;
}

double ComputeProbability(const KeyframeEvidence& evidence, const KeyframeVerdictModel& model) {
  return Logistic(evidence.significance) * Logistic(model.dot(KeyframeFactorsOf(evidence)));
}

}  // namespace waystone
