// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace waystone {
namespace {

using Eigen::Vector3d;

Vector3d FactorsOf(const Evidence& evidence) {
  return {1, std::log1p(static_cast<double>(evidence.inliers)), evidence.best_share};
}

Vector3d CoefficientsOf(const VerdictModel& model) {
  return {model.intercept, model.log_inliers, model.inlier_share};
}

constexpr double kConverged = 1e-9;

// log(1 + exp(x)) without overflow.
double SoftPlus(double x) { return std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))); }

double Logistic(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

}  // namespace

void FitOptions::Check() const {
  if (!(intercept_sigma > 0 && log_inliers_sigma > 0 && inlier_share_sigma > 0)) {
    throw MapError(ErrorCode::kBadOptions,
                   "verdict model: the deviations must be above 0; leave them at their defaults");
  }
}

double ProbabilityOf(const Evidence& evidence, const VerdictModel& model) {
  return Logistic(CoefficientsOf(model).dot(FactorsOf(evidence)));
}

VerdictModel FitVerdictModel(std::span<const VerdictSample> samples, const FitOptions& options) {
  options.Check();
  VerdictModel model;
  for (const VerdictSample& sample : samples) ++(sample.right ? model.positives : model.negatives);
  const Vector3d mean = CoefficientsOf(VerdictModel{});
  const Vector3d precision =
      Vector3d(options.intercept_sigma, options.log_inliers_sigma, options.inlier_share_sigma)
          .cwiseAbs2()
          .cwiseInverse();
  const double larger = std::max(model.positives, model.negatives);
  const auto weight = [&](const VerdictSample& sample) {
    return larger / (sample.right ? model.positives : model.negatives);
  };
  // Minus the logarithm of the posterior, but for a constant.
  const auto cost_of = [&](const Vector3d& coefficients) {
    double cost = 0.5 * precision.dot((coefficients - mean).cwiseAbs2());
    for (const VerdictSample& sample : samples) {
      const double log_odds = coefficients.dot(FactorsOf(sample.evidence));
      cost += weight(sample) * SoftPlus(sample.right ? -log_odds : log_odds);
    }
    return cost;
  };
  Vector3d coefficients = mean;
  double cost = cost_of(coefficients);
  constexpr int kMaxSteps = 100;
  for (int step = 0; step < kMaxSteps; ++step) {  // Newton's method; the problem is convex
    Vector3d gradient = precision.cwiseProduct(mean - coefficients);
    Eigen::Matrix3d curvature = precision.asDiagonal();
    for (const VerdictSample& sample : samples) {
      const Vector3d factors = FactorsOf(sample.evidence);
      const double p = Logistic(coefficients.dot(factors));
      gradient += weight(sample) * ((sample.right ? 1 : 0) - p) * factors;
      curvature += weight(sample) * p * (1 - p) * factors * factors.transpose();
    }
    Vector3d change = curvature.ldlt().solve(gradient);
    while (change.norm() > kConverged && cost_of(coefficients + change) > cost) change /= 2;
    if (change.norm() <= kConverged) break;
    coefficients += change;
    cost = cost_of(coefficients);
  }
  model.intercept = coefficients(0);
  model.log_inliers = std::max(coefficients(1), 0.1);  // more inliers never speak against a place
  model.inlier_share = coefficients(2);
  return model;
}

}  // namespace waystone
