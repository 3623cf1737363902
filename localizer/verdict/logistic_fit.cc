// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/logistic_fit.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/geometry/linear_algebra.h"

namespace waystone {
namespace {

constexpr int kMaxSteps = 100;
constexpr double kConverged = 1e-9;

// log(1 + e^x) without overflow.
double SoftPlus(double x) { return std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))); }

}  // namespace

double Logistic(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

Eigen::VectorXd FitLogistic(std::span<const LogisticSample> samples, const Eigen::VectorXd& mean,
                            const Eigen::VectorXd& sigma) {
  WS_CHECK(sigma.size() == mean.size() && (sigma.array() > 0).all(), "a prior without a width");
  const Eigen::VectorXd precision = sigma.cwiseAbs2().cwiseInverse();
  // Minus the logarithm of the posterior, but for a constant.
  const auto cost_of = [&](const Eigen::VectorXd& at) {
    double cost = 0.5 * precision.dot((at - mean).cwiseAbs2());
    for (const LogisticSample& sample : samples) {
      const double log_odds = at.dot(sample.factors);
      cost += sample.weight * SoftPlus(sample.right ? -log_odds : log_odds);
    }
    return cost;
  };
  Eigen::VectorXd at = mean;
  double cost = cost_of(at);
  for (int step = 0; step < kMaxSteps; ++step) {
    Eigen::VectorXd gradient = precision.cwiseProduct(mean - at);
    Eigen::MatrixXd curvature = precision.asDiagonal();
    for (const LogisticSample& sample : samples) {
      const Eigen::VectorXd& x = sample.factors;
      WS_CHECK(x.size() == mean.size(), "a sample of other factors");
      const double p = Logistic(at.dot(x));
      gradient += sample.weight * ((sample.right ? 1 : 0) - p) * x;
      curvature += sample.weight * p * (1 - p) * x * x.transpose();
    }
    Eigen::VectorXd change = SolveSymmetric(curvature, gradient);
    while (change.norm() > kConverged && cost_of(at + change) > cost) change /= 2;
    if (change.norm() <= kConverged) break;
    at += change;
    cost = cost_of(at);
  }
  return at;
}

}  // namespace waystone
