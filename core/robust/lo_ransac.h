// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/random.h"

namespace waystone {

// Locally optimized RANSAC (Chum, Matas and Kittler 2003): the one loop of Waystone's own robust
// estimators. What differs between them are a sampler and an estimator. Uncalibrated epipolar
// geometry (core/two_view/fundamental.h) is estimated by OpenCV's USAC_MAGSAC instead.
//
//   struct Sampler {
//     // A minimal sample, or nothing where this draw gives none (it still counts as a draw).
//     std::optional<Sample> Draw(Random& random);
//   };
//   struct Estimator {
//     // The models of a sample: any range of a type that the two functions below take. Empty for
//     // a degenerate sample.
//     auto Estimate(const Sample& sample) const;
//     // Support of a model, cheap: 0 for none, higher is better.
//     double Score(const Model& model) const;
//     // The model refined on its own support: a Fit has a member `score`, and is 0 by default.
//     Fit Refine(Model model) const;
//     // The probability that a draw consists only of inliers of this fit.
//     double SampleProbability(const Fit& fit) const;
//   };

struct RansacLimits {
  double confidence = 0.99;     // that at least one sample consists only of inliers, 0 to 1
  int max_samples = 1000;       // bounds the time
  int min_samples = 0;          // are drawn in any case
  double min_refine_share = 1;  // of the best score, above which a model is refined
};

// Number of samples so that with probability `confidence` one consists only of inliers (planar
// region graph, eq. (1)): k = log(1 - p) / log(1 - q), where q is the probability that a sample is.
inline double SamplesNeeded(double confidence, double sample_probability) {
  if (sample_probability <= 0) return std::numeric_limits<double>::infinity();
  if (sample_probability >= 1) return 1;
  return std::log(1 - confidence) / std::log1p(-sample_probability);
}

template <class Fit>
struct RansacResult {
  Fit best;         // as constructed where no model had support
  int samples = 0;  // that were drawn
};

// Draws samples until an all-inlier sample was likely among them. Deterministic for the random
// numbers; thread-safe where sampler and estimator are, with a Random per call.
template <class Sampler, class Estimator>
auto RunLoRansac(Sampler& sampler, const Estimator& estimator, const RansacLimits& limits,
                 Random& random) {
  using Model = std::decay_t<decltype(*std::begin(
      estimator.Estimate(*std::declval<decltype(sampler.Draw(random))>())))>;
  using Fit = decltype(estimator.Refine(std::declval<Model>()));
  RansacResult<Fit> result;
  double needed = limits.max_samples;
  for (; result.samples < needed; ++result.samples) {
    const auto sample = sampler.Draw(random);
    if (!sample) continue;
    for (auto& model : estimator.Estimate(*sample)) {
      if (estimator.Score(model) <= limits.min_refine_share * result.best.score) continue;
      Fit fit = estimator.Refine(std::move(model));
      if (fit.score <= result.best.score) continue;
      result.best = std::move(fit);
      needed = std::clamp<double>(
          SamplesNeeded(limits.confidence, estimator.SampleProbability(result.best)),
          std::min(limits.min_samples, limits.max_samples), limits.max_samples);
    }
  }
  return result;
}

}  // namespace waystone
