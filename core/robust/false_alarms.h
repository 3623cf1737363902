// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace waystone {

// ln of n over k, for 0 <= k <= n. Thread-safe.
inline double LogBinomial(int n, int k) {
  const int fewer = std::min(k, n - k);
  double sum = 0;  // not by lgamma, which writes a global variable
  for (int i = 1; i <= fewer; ++i) sum += std::log((n - fewer + i) / static_cast<double>(i));
  return sum;
}

// How a model is computed from a sample of matches.
struct MinimalSolver {
  int sample = 0;
  int solutions = 1;  // at most, per sample
};

// ln of the expected number of models that at least this many matches fit, where each match fits a
// model with the probability `alpha`, independently (Moisan and Stival, A probabilistic criterion
// to detect rigid point matches between two images, IJCV 2004: NFA = (n - s) m C(n, k) C(k, s)
// alpha^(k - s) for n matches, k inliers, and samples of s with m solutions). Below 0 is better
// than chance; 0 where only a sample fits. 0 < alpha <= 1. Thread-safe.
inline double LogFalseAlarms(int matches, int inliers, double alpha, const MinimalSolver& solver) {
  if (inliers <= solver.sample || matches < inliers) return 0;
  return std::log(static_cast<double>(matches - solver.sample) * solver.solutions) +
         LogBinomial(matches, inliers) + LogBinomial(inliers, solver.sample) +
         (inliers - solver.sample) * std::log(alpha);
}

}  // namespace waystone
