// SPDX-License-Identifier: Apache-2.0
#include "core/homography/find_plane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/robust/lo_ransac.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

using Sample = std::array<int, 4>;

// Samples of a point and three of its nearest active neighbours.
class LocalSampler {
 public:
  LocalSampler(std::span<const int> active, int points, const Neighbourhoods& neighbourhoods,
               int neighbourhood)
      : active_(active),
        is_active_(points, false),
        neighbourhoods_(neighbourhoods),
        neighbourhood_(neighbourhood) {
    for (int row : active) is_active_[row] = true;
  }

  std::optional<Sample> Draw(Random& random) {
    Sample sample;
    sample[0] = active_[random.Below(static_cast<int>(active_.size()))];
    pool_.clear();
    for (int neighbour : neighbourhoods_.of(sample[0])) {
      if (is_active_[neighbour]) pool_.push_back(neighbour);
      if (static_cast<int>(pool_.size()) == neighbourhood_) break;
    }
    if (pool_.size() < 3) return std::nullopt;
    for (int k = 0; k < 3; ++k) {  // a partial Fisher-Yates shuffle
      const int pick = k + random.Below(static_cast<int>(pool_.size()) - k);
      std::swap(pool_[k], pool_[pick]);
      sample[k + 1] = pool_[k];
    }
    return sample;
  }

 private:
  std::span<const int> active_;
  std::vector<char> is_active_;
  const Neighbourhoods& neighbourhoods_;
  int neighbourhood_;
  std::vector<int> pool_;
};

std::array<Vector2d, 4> Pick(const std::vector<Vector2d>& points, const Sample& sample) {
  return {points[sample[0]], points[sample[1]], points[sample[2]], points[sample[3]]};
}

std::optional<PlaneModel> SolveSample(const MatchedPoints& points, const Sample& sample,
                                      double min_height_ratio) {
  const auto from = Pick(points.from, sample);
  const auto to_from = HomographyFromFour(from, Pick(points.to, sample), min_height_ratio);
  if (!to_from) return std::nullopt;
  PlaneModel model{*to_from, Matrix3d::Identity()};
  if (points.reference.empty()) return model;
  const auto reference_from =
      HomographyFromFour(from, Pick(points.reference, sample), min_height_ratio);
  if (!reference_from) return std::nullopt;
  model.reference_from = *reference_from;
  return model;
}

std::optional<PlaneModel> FitModel(const MatchedPoints& points, std::span<const int> rows) {
  PointPairs pairs;
  for (int row : rows) pairs.Add(points.from[row], points.to[row]);
  const auto to_from = HomographyByDlt(pairs);
  if (!to_from) return std::nullopt;
  PlaneModel model{*to_from, Matrix3d::Identity()};
  if (points.reference.empty()) return model;
  for (size_t i = 0; i < rows.size(); ++i) pairs.b[i] = points.reference[rows[i]];
  const auto reference_from = HomographyByDlt(pairs);
  if (!reference_from) return std::nullopt;
  model.reference_from = *reference_from;
  return model;
}

PlaneFit Evaluate(const MatchedPoints& points, std::span<const int> active, const PlaneModel& model,
                  double max_error_px) {
  PlaneFit fit;
  fit.model = model;
  const PlaneModel inverse = Inverse(model);
  const double limit2 = max_error_px * max_error_px;
  for (int row : active) {
    const double error2 = PlaneError2(points, model, inverse, row);
    if (!(error2 < limit2)) continue;
    fit.inliers.push_back(row);
    fit.score += 1 - error2 / limit2;
  }
  return fit;
}

// Standard deviation of the errors' coordinates, from their median: outliers don't move it much.
double EstimateSigma(const MatchedPoints& points, const PlaneFit& fit) {
  const PlaneModel inverse = Inverse(fit.model);
  std::vector<double> errors2;
  for (int row : fit.inliers) errors2.push_back(PlaneError2(points, fit.model, inverse, row));
  return std::sqrt(Median(std::move(errors2))) / kRayleighMedian;
}

// Drops the inliers that the plane's own noise doesn't explain, and fits again without them.
PlaneFit Tighten(const MatchedPoints& points, std::span<const int> active, const PlaneFit& fit,
                 const LocalRansacOptions& options) {
  constexpr int kRounds = 3;
  PlaneFit tight = fit;
  for (int round = 0; round < kRounds && tight.inliers.size() >= 5; ++round) {
    const double bound = ErrorBound(EstimateSigma(points, tight), options);
    const std::optional<PlaneModel> model = FitModel(points, tight.inliers);
    if (!model) break;
    tight = Evaluate(points, active, *model, bound);
  }
  tight.samples = fit.samples;
  return tight.inliers.size() >= 5 ? tight : fit;
}

// Planes through samples of four, for RunLoRansac.
class PlaneEstimator {
 public:
  PlaneEstimator(const MatchedPoints& points, std::span<const int> active,
                 const Neighbourhoods& neighbourhoods, const LocalRansacOptions& options)
      : points_(points), active_(active), neighbourhoods_(neighbourhoods), options_(options) {}

  std::vector<PlaneFit> Estimate(const Sample& sample) const {
    const auto model = SolveSample(points_, sample, options_.min_height_ratio);
    if (!model) return {};
    return {Evaluate(points_, active_, *model, options_.max_error_px)};
  }

  double Score(const PlaneFit& fit) const { return fit.score; }

  PlaneFit Refine(const PlaneFit& fit) const {
    return LocalOptimize(points_, active_, fit, options_);
  }

  // A local sample's first point is an inlier with the share of inliers among all, the other three
  // with the share among the neighbours of inliers.
  double SampleProbability(const PlaneFit& fit) const {
    std::vector<char> state(points_.size(), 0);
    for (int row : active_) state[row] = 1;
    for (int row : fit.inliers) state[row] = 2;
    int64_t neighbours = 0;
    int64_t inliers = 0;
    for (int row : fit.inliers) {
      int seen = 0;
      for (int neighbour : neighbourhoods_.of(row)) {
        if (state[neighbour] == 0) continue;
        ++neighbours;
        inliers += state[neighbour] == 2;
        if (++seen == options_.neighbourhood) break;
      }
    }
    const double global = static_cast<double>(fit.inliers.size()) / active_.size();
    const double local = neighbours == 0 ? 0 : static_cast<double>(inliers) / neighbours;
    return global * local * local * local;
  }

 private:
  const MatchedPoints& points_;
  std::span<const int> active_;
  const Neighbourhoods& neighbourhoods_;
  const LocalRansacOptions& options_;
};

}  // namespace

void LocalRansacOptions::Check() const {
  CheckFields("ransac", *this);
  if (max_error_px >= min_error_px) return;
  throw MapError(
      ErrorCode::kBadOptions,
      "ransac.max_error_px is below min_error_px; give at least " + std::to_string(min_error_px));
}

double PlaneError2(const MatchedPoints& points, const PlaneModel& model, const PlaneModel& inverse,
                   int i) {
  const double error2 =
      SymmetricTransferError2(model.to_from, inverse.to_from, points.from[i], points.to[i]);
  if (points.reference.empty()) return error2;
  const double reference2 =
      (Apply(inverse.reference_from, points.reference[i]) - points.from[i]).squaredNorm();
  return reference2 > error2 ? reference2 : error2;  // NaN stays NaN: never an inlier
}

PlaneModel Inverse(const PlaneModel& model) {
  return {model.to_from.inverse(), model.reference_from.inverse()};
}

double ErrorBound(double sigma_px, const LocalRansacOptions& options) {
  return std::clamp(options.max_sigmas * sigma_px, options.min_error_px, options.max_error_px);
}

PlaneFit LocalOptimize(const MatchedPoints& points, std::span<const int> active,
                       const PlaneFit& start, const LocalRansacOptions& options) {
  PlaneFit best = start;
  std::vector<int> support = start.inliers;
  for (int refit = 0; refit < options.max_refits && support.size() >= 5; ++refit) {
    const std::optional<PlaneModel> model = FitModel(points, support);
    if (!model) break;
    PlaneFit next = Evaluate(points, active, *model, options.max_error_px);
    // A local sample's homography exceeds the bound a little farther away: the first refits use a
    // wider one.
    const bool wide = refit < options.wide_refits;
    if (next.score > best.score) {
      best = std::move(next);
    } else if (!wide) {
      break;
    }
    support =
        wide ? Evaluate(points, active, *model, 2 * options.max_error_px).inliers : best.inliers;
  }
  best.samples = start.samples;
  return best;
}

std::optional<PlaneFit> FindPlane(const MatchedPoints& points, std::span<const int> active,
                                  const Neighbourhoods& neighbourhoods,
                                  const LocalRansacOptions& options, Random& random) {
  if (active.size() < 4) return std::nullopt;
  LocalSampler sampler(active, points.size(), neighbourhoods, options.neighbourhood);
  const PlaneEstimator estimator(points, active, neighbourhoods, options);
  // Local samples extrapolate badly: one that is much worse than the best may still grow past it,
  // hence min_refit_share.
  auto [best, samples] = RunLoRansac(sampler, estimator,
                                     {.confidence = options.confidence,
                                      .max_samples = options.max_samples,
                                      .min_refine_share = options.min_refit_share},
                                     random);
  if (best.inliers.size() < 4) return std::nullopt;
  best.samples = samples;
  return Tighten(points, active, best, options);
}

std::optional<PlaneFit> FindPlane(const MatchedPoints& points, const LocalRansacOptions& options,
                                  uint64_t seed) {
  const Neighbourhoods neighbourhoods(points.from, 2 * options.neighbourhood);
  std::vector<int> all(points.size());
  std::iota(all.begin(), all.end(), 0);
  Random random(seed);
  return FindPlane(points, all, neighbourhoods, options, random);
}

}  // namespace waystone
