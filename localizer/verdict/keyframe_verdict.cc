// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/keyframe_verdict.h"

#include <algorithm>
#include <cmath>

#include "localizer/verdict/logistic_fit.h"

namespace waystone {
namespace {

// Below this share of found features a keyframe speaks against its planes, by this much log-odds
// where none is found.
constexpr double kDoubtfulShare = 0.2;
constexpr double kMaxDoubt = 8;
// Probabilities nearer to 0 or 1 count as this near: their log-odds stay finite.
constexpr double kLeast = 1e-9;

double ToLogOdds(double probability) {
  const double p = std::clamp(probability, kLeast, 1 - kLeast);
  return std::log(p / (1 - p));
}

}  // namespace

double ComputeProbability(const KeyframeEvidence& evidence, const KeyframeVerdictModel& model) {
  return Logistic(model.intercept + model.log_inliers * std::log1p(evidence.inliers) +
                  model.found_share * evidence.found_share + model.coverage * evidence.coverage);
}

double JoinProbabilities(double by_planes, double by_keyframe, const KeyframeEvidence& evidence) {
  const double missing = std::max(0.0, kDoubtfulShare - evidence.found_share) / kDoubtfulShare;
  const double doubted = ToLogOdds(by_planes) - kMaxDoubt * missing;
  return Logistic(std::max(doubted, ToLogOdds(by_keyframe)));
}

}  // namespace waystone
