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

// The negative log posterior up to a constant, with its derivatives.
struct Posterior {
  double cost = 0;
  Eigen::VectorXd gradient;  // of the logarithm of the posterior: uphill
  Eigen::MatrixXd curvature;
};

Posterior PosteriorAt(const Eigen::VectorXd& at, std::span<const LogisticSample> samples,
                      const LogisticPrior& prior) {
  const Eigen::VectorXd precision = prior.sigma.cwiseAbs2().cwiseInverse();
  Posterior posterior{0.5 * precision.dot((at - prior.mean).cwiseAbs2()),
                      precision.cwiseProduct(prior.mean - at), precision.asDiagonal()};
  for (const LogisticSample& sample : samples) {
    const Eigen::VectorXd& x = sample.factors;
    WS_CHECK(x.size() == at.size(), "a sample of other factors");
    const double log_odds = at.dot(x);
    const double p = Logistic(log_odds);
    posterior.cost += sample.weight * SoftPlus(sample.right ? -log_odds : log_odds);
    posterior.gradient += sample.weight * ((sample.right ? 1 : 0) - p) * x;
    posterior.curvature += sample.weight * p * (1 - p) * x * x.transpose();
  }
  return posterior;
}

// Newton's step for the coefficients that are free; those held at a bound stay.
Eigen::VectorXd FreeStep(const Eigen::VectorXd& at, const Posterior& posterior,
                         const LogisticPrior& prior) {
  Eigen::VectorXd gradient = posterior.gradient;
  Eigen::MatrixXd curvature = posterior.curvature;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const bool held = (at(i) <= prior.lower(i) && gradient(i) < 0) ||
                      (at(i) >= prior.upper(i) && gradient(i) > 0);
    if (!held) continue;
    gradient(i) = 0;
    curvature.row(i).setZero();
    curvature.col(i).setZero();
    curvature(i, i) = 1;
  }
  return SolveSymmetric(curvature, gradient);
}

}  // namespace

double Logistic(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

Eigen::VectorXd FitLogistic(std::span<const LogisticSample> samples, const LogisticPrior& prior) {
  const Eigen::Index size = prior.mean.size();
  WS_CHECK(prior.sigma.size() == size && (prior.sigma.array() > 0).all(),
           "a prior without a width");
  WS_CHECK(prior.lower.size() == size && prior.upper.size() == size &&
               (prior.lower.array() <= prior.mean.array()).all() &&
               (prior.mean.array() <= prior.upper.array()).all(),
           "a prior beyond its bounds");
  Eigen::VectorXd at = prior.mean;
  Posterior posterior = PosteriorAt(at, samples, prior);
  for (int step = 0; step < kMaxSteps; ++step) {
    Eigen::VectorXd change = FreeStep(at, posterior, prior);
    const auto moved = [&]() -> Eigen::VectorXd {
      return (at + change).cwiseMax(prior.lower).cwiseMin(prior.upper);
    };
    while (change.norm() > kConverged &&
           PosteriorAt(moved(), samples, prior).cost > posterior.cost) {
      change /= 2;
    }
    const Eigen::VectorXd next = moved();
    if ((next - at).norm() <= kConverged) break;
    at = next;
    posterior = PosteriorAt(at, samples, prior);
  }
  return at;
}

}  // namespace waystone
