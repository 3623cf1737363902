// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/verdict_model.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/error.h"
#include "localizer/verdict/logistic_fit.h"

namespace waystone {
namespace {

using Eigen::Vector3d;

constexpr double kLeastWeight = 0.1;  // of the inliers, so that they always distinguish places

Vector3d FactorsOf(const Evidence& evidence) {
  return {1, std::log1p(static_cast<double>(evidence.inliers)), evidence.best_share};
}

Vector3d CoefficientsOf(const VerdictModel& model) {
  return {model.intercept, model.log_inliers, model.inlier_share};
}

}  // namespace

void FitOptions::Check() const { CheckFields("verdict", *this); }

double EstimateProbability(const Evidence& evidence, const VerdictModel& model) {
  return Logistic(CoefficientsOf(model).dot(FactorsOf(evidence)));
}

VerdictModel FitVerdictModel(std::span<const VerdictSample> samples, const FitOptions& options) {
  options.Check();
  VerdictModel model;
  for (const VerdictSample& sample : samples) ++(sample.right ? model.positives : model.negatives);
  if (std::min(model.positives, model.negatives) < options.min_samples) return model;
  // More inliers, and a larger share of them, never count against a place.
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const LogisticPrior prior{
      CoefficientsOf(VerdictModel{}),
      Vector3d(options.intercept_sigma, options.log_inliers_sigma, options.inlier_share_sigma),
      Vector3d(-kAny, kLeastWeight, 0), Vector3d(kAny, kAny, kAny)};
  const double larger = std::max(model.positives, model.negatives);
  std::vector<LogisticSample> cases;
  for (const VerdictSample& sample : samples) {
    const double weight = larger / (sample.right ? model.positives : model.negatives);
    cases.push_back({FactorsOf(sample.evidence), sample.right, weight});
  }
  const Eigen::VectorXd coefficients = FitLogistic(cases, prior);
  model.intercept = coefficients(0);
  model.log_inliers = coefficients(1);
  model.inlier_share = coefficients(2);
  return model;
}

}  // namespace waystone
