// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

namespace waystone {

// What is known of one case: log(p / (1 - p)) = coefficients . factors is to be found.
struct LogisticSample {
  Eigen::VectorXd factors;  // the first is usually 1: its coefficient is the intercept
  bool right = false;
  double weight = 1;  // how much it counts, above 0
};

// 1 / (1 + e^-x), in (0, 1) but for rounding.
double Logistic(double log_odds);

// What is known of the coefficients before any sample: they are normally distributed, and their
// signs may be given. All vectors have one size.
struct LogisticPrior {
  Eigen::VectorXd mean;
  Eigen::VectorXd sigma;  // above 0
  Eigen::VectorXd lower;  // the least that each may be, at most its mean; -infinity for any
  Eigen::VectorXd upper;  // the most, at least its mean
};

// The most probable coefficients of a logistic regression under the prior, so that samples which
// are told apart without an error don't drive them to infinity, and evidence can't count against
// what it means. No samples give the mean. Deterministic; projected Newton steps on a convex
// problem. All factors have the size of the mean (WS_CHECK).
Eigen::VectorXd FitLogistic(std::span<const LogisticSample> samples, const LogisticPrior& prior);

}  // namespace waystone
