// SPDX-License-Identifier: Apache-2.0
#include "core/homography/plane_labelling.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace waystone {
void LabellingOptions::Check() const {
  const bool good = min_sigmas > 0 && max_sigmas >= std::max(1.0, min_sigmas) && min_sigma_px > 0 &&
                    max_sigma_px >= min_sigma_px && tail > 0 && plane_cost >= 0 &&
                    smoothness >= 0 && companions >= 1 && rounds >= 1;
  if (!good) {
    throw MapError(ErrorCode::kBadOptions, "plane labels: option out of range; use the defaults");
  }
}

PlaneLabelling::PlaneLabelling(const MatchedPoints& points, const Neighbourhoods& neighbourhoods,
                               const LabellingOptions& options)
    : points_(&points),
      neighbourhoods_(&neighbourhoods),
      options_(options),
      labels_(points.size(), kNoPlane),
      sigmas_(options.min_sigmas) {
  options_.Check();
}

void PlaneLabelling::Add(const Eigen::Matrix3d& to_from, double sigma_px, bool fixed) {
  Labelled plane{
      to_from, std::clamp(sigma_px, options_.min_sigma_px, options_.max_sigma_px), fixed, {}};
  Measure(plane);
  planes_.push_back(std::move(plane));
}

void PlaneLabelling::Remove(int plane) {
  planes_.erase(planes_.begin() + plane);
  for (int& label : labels_) {
    if (label == plane) {
      label = kNoPlane;
    } else if (label > plane) {
      --label;
    }
  }
}

void PlaneLabelling::Replace(int plane, const Eigen::Matrix3d& to_from, double sigma_px) {
  planes_[plane].to_from = to_from;
  planes_[plane].sigma_px = std::clamp(sigma_px, options_.min_sigma_px, options_.max_sigma_px);
  Measure(planes_[plane]);
}

std::vector<int> PlaneLabelling::RowsOf(int plane) const {
  std::vector<int> rows;
  for (int row = 0; row < points_->size(); ++row) {
    if (labels_[row] == plane) rows.push_back(row);
  }
  return rows;
}

void PlaneLabelling::Settle() {
  for (int round = 0; round < options_.rounds; ++round) {
    EstimateSigmas();
    if (!Label() && round > 0) break;
    Refit();
  }
  EstimateSigmas();
  Label();
}

void PlaneLabelling::Measure(Labelled& plane) const {
  const Eigen::Matrix3d inverse = plane.to_from.inverse();
  plane.errors_px.resize(points_->size());
  for (int row = 0; row < points_->size(); ++row) {
    const double error2 =
        SymmetricTransferError2(plane.to_from, inverse, points_->from[row], points_->to[row]);
    plane.errors_px[row] = std::isfinite(error2) ? static_cast<float>(std::sqrt(error2)) : 1e9F;
  }
}

// How far the planes' errors reach, in their standard deviations: as far as a match at that
// distance is likelier a plane's than one of the things beside the planes, whose density is taken
// from those farther out. One number for all planes of a pair, because only all together give
// enough to count.
void PlaneLabelling::EstimateSigmas() {
  const int last = static_cast<int>(options_.max_sigmas);
  std::vector<int> shells(2 * last + 1, 0);
  for (int row = 0; row < points_->size(); ++row) {
    double nearest = 2 * last + 1;
    for (const Labelled& plane : planes_) {
      nearest = std::min(nearest, plane.errors_px[row] / plane.sigma_px);
    }
    if (nearest < 2 * last) ++shells[static_cast<int>(nearest)];
  }
  double clutter = 0;  // matches a shell beyond the planes' reach
  for (int shell = last; shell < 2 * last; ++shell) clutter += shells[shell];
  clutter /= last;
  sigmas_ = options_.min_sigmas;
  for (int shell = static_cast<int>(options_.min_sigmas); shell < last; ++shell) {
    if (shells[shell] <= 2 * clutter) break;
    sigmas_ = shell + 1;
  }
}

double PlaneLabelling::Disagreement(int row, int plane) const {
  int others = 0;
  int seen = 0;
  for (int neighbour : neighbourhoods_->of(row)) {
    others += labels_[neighbour] != plane && labels_[neighbour] != kNoPlane;
    if (++seen == options_.companions) break;
  }
  return static_cast<double>(others) / options_.companions;
}

// Of an error of a plane's own match, by Student's distribution in two dimensions.
double PlaneLabelling::Cost(double sigmas) const {
  const double tail = options_.tail;
  return (tail + 2) / 2 * std::log1p(sigmas * sigmas / tail);
}

double PlaneLabelling::CostOf(int row, int plane) const {
  const double sigma_px = planes_[plane].sigma_px;
  return Cost(planes_[plane].errors_px[row] / sigma_px) + 2 * std::log(sigma_px) +
         options_.smoothness * Disagreement(row, plane);
}

double PlaneLabelling::Gain(const std::vector<int>& rows, const Eigen::Matrix3d& to_from,
                            int plane) const {
  const Labelled& old = planes_[plane];
  const Eigen::Matrix3d inverse = to_from.inverse();
  double gain = 0;
  for (int row : rows) {
    const double error_px =
        std::sqrt(SymmetricTransferError2(to_from, inverse, points_->from[row], points_->to[row]));
    const double better = Cost(old.errors_px[row] / old.sigma_px) - Cost(error_px / old.sigma_px);
    if (better > 0) gain += better;  // what it explains worse stays the plane's
  }
  return gain;
}

double PlaneLabelling::Energy() const {
  double energy = options_.plane_cost * planes();
  for (int row = 0; row < points_->size(); ++row) {
    energy += labels_[row] == kNoPlane ? options_.outlier_cost : CostOf(row, labels_[row]);
  }
  return energy;
}

// Improves the labels one by one (iterated conditional modes). Whether any changed.
bool PlaneLabelling::Label() {
  constexpr int kMaxSweeps = 6;
  bool any = false;
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool changed = false;
    for (int row = 0; row < points_->size(); ++row) {
      double least = options_.outlier_cost;
      int label = kNoPlane;
      for (int p = 0; p < planes(); ++p) {
        if (planes_[p].errors_px[row] >= bound_px(p)) continue;
        const double cost = CostOf(row, p);
        if (cost < least) {
          least = cost;
          label = p;
        }
      }
      changed = changed || label != labels_[row];
      labels_[row] = label;
    }
    any = any || changed;
    if (!changed) break;
  }
  return any;
}

void PlaneLabelling::Refit() {
  for (int p = 0; p < planes(); ++p) {
    Labelled& plane = planes_[p];
    const std::vector<int> rows = RowsOf(p);
    if (plane.fixed || rows.size() < 5) continue;
    PointPairs pairs;
    std::vector<double> weights;  // those of Student's distribution
    for (int row : rows) {
      const double sigmas = plane.errors_px[row] / plane.sigma_px;
      pairs.Add(points_->from[row], points_->to[row]);
      weights.push_back((options_.tail + 2) / (options_.tail + sigmas * sigmas));
    }
    const auto to_from = HomographyByDlt(pairs, weights);
    if (!to_from) continue;
    plane.to_from = *to_from;
    Measure(plane);
    std::vector<float> errors;
    for (int row : rows) errors.push_back(plane.errors_px[row]);
    const auto middle = errors.begin() + static_cast<ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    plane.sigma_px =
        std::clamp(*middle / kRayleighMedian, options_.min_sigma_px, options_.max_sigma_px);
  }
}

}  // namespace waystone
