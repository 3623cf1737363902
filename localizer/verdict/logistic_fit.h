// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

namespace waystone {

// One sample for fitting log(p / (1 - p)) = coefficients . factors.
struct LogisticSample {
  Eigen::VectorXd factors;  // the first is usually 1: its coefficient is the intercept
  bool right = false;
  double weight = 1;  // above 0
};

// 1 / (1 + e^-x), in (0, 1) up to rounding. Pure; thread-safe.
double Logistic(double log_odds);

// The prior of the coefficients: normally distributed, within bounds such as a given sign. All
// vectors have the same size.
struct LogisticPrior {
  Eigen::VectorXd mean;
  Eigen::VectorXd sigma;  // above 0
  Eigen::VectorXd lower;  // the least that each may be, at most its mean; -infinity for any
  Eigen::VectorXd upper;  // the most, at least its mean
};

// The most probable coefficients of a logistic regression under the prior, so that perfectly
// separable samples don't drive them to infinity, and evidence can't count against its meaning.
// Without samples the result is the mean. Projected Newton steps on a convex problem.
// Deterministic; thread-safe. All factors have the size of the mean (WS_CHECK).
Eigen::VectorXd FitLogistic(std::span<const LogisticSample> samples, const LogisticPrior& prior);

}  // namespace waystone
