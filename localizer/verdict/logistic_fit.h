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

// The most probable coefficients of a logistic regression when they are normally distributed around
// `mean` with sigmas `sigma` (above 0), so that samples which are told apart without an error
// don't drive them to infinity. No samples give the mean. Deterministic; Newton's method on a
// convex problem. All factors have the size of `mean` (WS_CHECK).
Eigen::VectorXd FitLogistic(std::span<const LogisticSample> samples, const Eigen::VectorXd& mean,
                            const Eigen::VectorXd& sigma);

}  // namespace waystone
