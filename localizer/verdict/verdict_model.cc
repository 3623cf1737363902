// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/verdict_model.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "localizer/verdict/logistic_fit.h"

namespace waystone {
namespace {

using Eigen::Vector3d;

Vector3d FactorsOf(const Evidence& evidence) {
  return {1, std::log1p(static_cast<double>(evidence.inliers)), evidence.best_share};
}

Vector3d CoefficientsOf(const VerdictModel& model) {
  return {model.intercept, model.log_inliers, model.inlier_share};
}

}  // namespace

double EstimateProbability(const Evidence& evidence, const VerdictModel& model) {
  return Logistic(CoefficientsOf(model).dot(FactorsOf(evidence)));
}

VerdictModel FitVerdictModel(std::span<const VerdictSample> samples, const FitOptions& options) {
  options.Check();
  VerdictModel model;
  for (const VerdictSample& sample : samples) ++(sample.right ? model.positives : model.negatives);
  const Vector3d mean = CoefficientsOf(VerdictModel{});
  const Vector3d sigma(options.intercept_sigma, options.log_inliers_sigma,
                       options.inlier_share_sigma);
  const double larger = std::max(model.positives, model.negatives);
  std::vector<LogisticSample> cases;
  for (const VerdictSample& sample : samples) {
    const double weight = larger / (sample.right ? model.positives : model.negatives);
    cases.push_back({FactorsOf(sample.evidence), sample.right, weight});
  }
  const Eigen::VectorXd coefficients = FitLogistic(cases, mean, sigma);
  model.intercept = coefficients(0);
  model.log_inliers = std::max(coefficients(1), 0.1);  // more inliers never speak against a place
  model.inlier_share = coefficients(2);
  return model;
}

}  // namespace waystone
