// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance_verdict.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/check.h"
#include "core/base/option_range.h"

namespace waystone {
namespace {

using Eigen::Vector3d;

constexpr int kMaxSteps = 100;
constexpr double kConverged = 1e-9;

// Names by kind, ascending, as the map keeps them.
constexpr const char* kTerms[2][2] = {{"cost", "margin"}, {"log_inlier_margin", "log_inliers"}};

// 1, then the evidence in the order of the terms.
Vector3d FactorsOf(const AppearanceEvidence& evidence, bool verified) {
  if (!verified) return {1, evidence.cost, evidence.margin};
  return {1, evidence.log_inlier_margin, evidence.log_inliers};
}

Vector3d CoefficientsOf(const AppearanceVerdict& model) {
  return {model.intercept, model.terms[0].weight, model.terms[1].weight};
}

bool IsOfKind(const AppearanceVerdict& model, bool verified) {
  return model.terms.size() == 2 && model.terms[0].name == kTerms[verified][0] &&
         model.terms[1].name == kTerms[verified][1];
}

AppearanceVerdict ModelOf(const Vector3d& coefficients, bool verified) {
  AppearanceVerdict model;
  model.intercept = coefficients(0);
  model.terms = {{kTerms[verified][0], coefficients(1)}, {kTerms[verified][1], coefficients(2)}};
  return model;
}

double Logistic(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

// log(1 + e^x), without overflow.
double SoftPlus(double x) { return std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))); }

}  // namespace

void AppearanceFitOptions::Check() const {
  CheckRange("intercept_sigma", intercept_sigma, 0.01, 100);
  CheckRange("weight_sigma", weight_sigma, 0.01, 100);
}

AppearanceVerdict DefaultVerdict(bool verified) {
  // More than 13 inliers that no other place comes near; a view of half the typical cost that
  // stands out.
  return verified ? ModelOf({-12, 1.5, 4}, true) : ModelOf({5, -10, 15}, false);
}

AppearanceVerdict VerdictFor(const AppearanceLayer& layer, bool verified) {
  if (layer.verdict && IsOfKind(*layer.verdict, verified)) return *layer.verdict;
  return DefaultVerdict(verified);
}

double ProbabilityOf(const AppearanceEvidence& evidence, const AppearanceVerdict& model) {
  WS_CHECK(IsOfKind(model, evidence.verified), "a model for evidence of another kind");
  return Logistic(CoefficientsOf(model).dot(FactorsOf(evidence, evidence.verified)));
}

AppearanceVerdict FitAppearanceVerdict(std::span<const AppearanceSample> samples, bool verified,
                                       const AppearanceFitOptions& options) {
  options.Check();
  const Vector3d mean = CoefficientsOf(DefaultVerdict(verified));
  const Vector3d sigma(options.intercept_sigma, options.weight_sigma, options.weight_sigma);
  const Vector3d precision = sigma.cwiseAbs2().cwiseInverse();
  const auto positives = std::ranges::count_if(samples, &AppearanceSample::right);
  const auto negatives = std::ssize(samples) - positives;
  const auto weight = [&](const AppearanceSample& sample) {
    const auto alike = static_cast<double>(sample.right ? positives : negatives);
    return static_cast<double>(samples.size()) / (2 * alike);
  };
  const auto cost_of = [&](const Vector3d& at) {
    double cost = 0.5 * precision.dot((at - mean).cwiseAbs2());
    for (const AppearanceSample& sample : samples) {
      const double log_odds = at.dot(FactorsOf(sample.evidence, verified));
      cost += weight(sample) * SoftPlus(sample.right ? -log_odds : log_odds);
    }
    return cost;
  };
  Vector3d at = mean;
  for (int step = 0; step < kMaxSteps; ++step) {  // Newton's method; the problem is convex
    Vector3d gradient = precision.cwiseProduct(mean - at);
    Eigen::Matrix3d curvature = precision.asDiagonal();
    for (const AppearanceSample& sample : samples) {
      const Vector3d factors = FactorsOf(sample.evidence, verified);
      const double p = Logistic(at.dot(factors));
      gradient += weight(sample) * ((sample.right ? 1 : 0) - p) * factors;
      curvature += weight(sample) * p * (1 - p) * factors * factors.transpose();
    }
    Vector3d change = curvature.ldlt().solve(gradient);
    while (change.norm() > kConverged && cost_of(at + change) > cost_of(at)) change /= 2;
    if (change.norm() <= kConverged) break;
    at += change;
  }
  AppearanceVerdict model = ModelOf(at, verified);
  model.positives = static_cast<int>(positives);
  model.negatives = static_cast<int>(negatives);
  return model;
}

}  // namespace waystone
