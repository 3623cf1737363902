// SPDX-License-Identifier: Apache-2.0
#include "core/homography/plane_labelling.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/homography/binary_energy.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

using Companions = std::vector<std::vector<int>>;

std::shared_ptr<const Companions> FindCompanions(const Neighbourhoods& neighbourhoods, int size,
                                                 int count) {
  auto companions = std::make_shared<Companions>(size);
  for (int row = 0; row < size; ++row) {
    int seen = 0;
    for (const int neighbour : neighbourhoods.of(row)) {
      (*companions)[row].push_back(neighbour);
      (*companions)[neighbour].push_back(row);
      if (++seen == count) break;
    }
  }
  return companions;
}

}  // namespace

void LabellingOptions::Check() const {
  CheckFields("labelling", *this);
  if (max_sigmas >= min_sigmas && max_sigma_px >= min_sigma_px) return;
  throw MapError(
      ErrorCode::kBadOptions,
      "labelling.max_sigmas and max_sigma_px must be at least min_sigmas and min_sigma_px");
}

PlaneLabelling::PlaneLabelling(const MatchedPoints& points, const Neighbourhoods& neighbourhoods,
                               const LabellingOptions& options)
    : points_(&points),
      options_(options),
      companions_(FindCompanions(neighbourhoods, points.size(), options.companions)),
      labels_(points.size(), kNoPlane),
      sigmas_(options.min_sigmas) {
  options_.Check();
}

void PlaneLabelling::Add(const Eigen::Matrix3d& to_from, double sigma_px, bool fixed) {
  Labelled plane{to_from, sigma_px, fixed, {}, {}};
  Measure(plane);
  SetSigma(plane, sigma_px);
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
  Measure(planes_[plane]);
  SetSigma(planes_[plane], sigma_px);
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
    for (int p = 0; p < planes(); ++p) Refit(p);
  }
  EstimateSigmas();
  Label();
}

void PlaneLabelling::Grow(int plane) {
  EstimateSigmas();
  Expand(plane);
  Refit(plane);
  Release();
  Expand(plane);
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

void PlaneLabelling::SetSigma(Labelled& plane, double sigma_px) const {
  plane.sigma_px = std::clamp(sigma_px, options_.min_sigma_px, options_.max_sigma_px);
  plane.costs.resize(plane.errors_px.size());
  const double sigma_cost = 2 * std::log(plane.sigma_px);
  for (size_t row = 0; row < plane.costs.size(); ++row) {
    plane.costs[row] =
        static_cast<float>(ErrorCost(plane.errors_px[row] / plane.sigma_px) + sigma_cost);
  }
}

// How far the planes' errors reach, in their standard deviations: as far as a match at that
// distance is more likely to be a plane's than clutter, whose density is taken from matches farther
// out. One number for all planes of a pair of images, because only all together give enough matches
// to count.
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
  double clutter = 0;  // matches per shell beyond the planes' reach
  for (int shell = last; shell < 2 * last; ++shell) clutter += shells[shell];
  clutter /= last;
  sigmas_ = options_.min_sigmas;
  for (int shell = static_cast<int>(options_.min_sigmas); shell < last; ++shell) {
    if (shells[shell] <= 2 * clutter) break;
    sigmas_ = shell + 1;
  }
}

// The cost of an error of a plane's own match, by Student's distribution in two dimensions.
double PlaneLabelling::ErrorCost(double sigmas) const {
  const double tail = options_.tail;
  return (tail + 2) / 2 * std::log1p(sigmas * sigmas / tail);
}

double PlaneLabelling::OwnCost(int row, int label) const {
  return label == kNoPlane ? options_.outlier_cost : planes_[label].costs[row];
}

// The cost of a pair of companions: those with different planes disagree.
double PlaneLabelling::PairCost(int label, int other) const {
  const bool disagree = label != other && label != kNoPlane && other != kNoPlane;
  return disagree ? options_.smoothness / options_.companions : 0;
}

double PlaneLabelling::Disagreement(int row) const {
  double cost = 0;
  for (const int other : (*companions_)[row]) cost += PairCost(labels_[row], labels_[other]);
  return cost;
}

double PlaneLabelling::Energy() const {
  double energy = options_.plane_cost * planes();
  for (int row = 0; row < points_->size(); ++row) {
    energy += OwnCost(row, labels_[row]) + Disagreement(row) / 2;  // a pair counts once
  }
  return energy;
}

PlaneLabelling::Better PlaneLabelling::BetterWith(const Eigen::Matrix3d& to_from, double sigma_px,
                                                  const std::vector<int>& rows) const {
  const double sigma_cost = 2 * std::log(sigma_px);
  // The error beyond which even a match of no plane is better explained without it.
  const double reach2_px =
      sigma_px * sigma_px * options_.tail *
      std::expm1(std::max(0.0, options_.outlier_cost - sigma_cost) * 2 / (options_.tail + 2));
  const Eigen::Matrix3d inverse = to_from.inverse();
  Better better;
  for (const int row : rows) {
    const Eigen::Vector2d& from = points_->from[row];
    const Eigen::Vector2d& to = points_->to[row];
    if (!((Apply(to_from, from) - to).squaredNorm() < 2 * reach2_px)) continue;
    const double error2 = SymmetricTransferError2(to_from, inverse, from, to);
    if (!(error2 < reach2_px)) continue;
    const double gain =
        OwnCost(row, labels_[row]) - ErrorCost(std::sqrt(error2) / sigma_px) - sigma_cost;
    if (gain <= 0) continue;
    better.gain += gain;
    better.rows.push_back(row);
  }
  return better;
}

std::optional<Eigen::Matrix3d> PlaneLabelling::Refitted(const Eigen::Matrix3d& to_from,
                                                        double sigma_px,
                                                        const std::vector<int>& rows) const {
  const Eigen::Matrix3d inverse = to_from.inverse();
  std::vector<double> sigmas;
  for (const int row : rows) {
    const double error2 =
        SymmetricTransferError2(to_from, inverse, points_->from[row], points_->to[row]);
    sigmas.push_back(std::sqrt(error2) / sigma_px);
  }
  return Fit(rows, sigmas);
}

// Fits a homography to these matches, whose errors so far are `sigmas` standard deviations.
std::optional<Eigen::Matrix3d> PlaneLabelling::Fit(const std::vector<int>& rows,
                                                   const std::vector<double>& sigmas) const {
  PointPairs pairs;
  std::vector<double> weights;  // those of Student's distribution
  for (size_t i = 0; i < rows.size(); ++i) {
    pairs.Add(points_->from[rows[i]], points_->to[rows[i]]);
    weights.push_back((options_.tail + 2) / (options_.tail + sigmas[i] * sigmas[i]));
  }
  return HomographyByDlt(pairs, weights);
}

// Improves the labels until no move does. Returns whether any changed.
bool PlaneLabelling::Label() {
  constexpr int kMaxSweeps = 6;
  bool any = Release();
  int settled = 0;  // planes in a row that would gain no match
  for (int sweep = 0; sweep < kMaxSweeps && settled < planes(); ++sweep) {
    for (int p = 0; p < planes() && settled < planes(); ++p) {
      const bool expanded = Expand(p);
      settled = expanded ? 1 : settled + 1;
      any = any || expanded;
    }
    if (!Drop()) continue;
    settled = 0;
    any = true;
  }
  return any;
}

// Releases matches that their planes no longer reach. Returns whether there were any.
bool PlaneLabelling::Release() {
  bool any = false;
  for (int row = 0; row < points_->size(); ++row) {
    int& label = labels_[row];
    if (label == kNoPlane || planes_[label].errors_px[row] < bound_px(label)) continue;
    label = kNoPlane;
    any = true;
  }
  return any;
}

// An expansion move (Boykov, Veksler and Zabih 2001): gives the plane the set of matches that
// lowers the energy most.
bool PlaneLabelling::Expand(int plane) {
  std::vector<int> rows;
  std::vector<int> variable_of(points_->size(), -1);
  for (int row = 0; row < points_->size(); ++row) {
    if (labels_[row] == plane || planes_[plane].errors_px[row] >= bound_px(plane)) continue;
    variable_of[row] = static_cast<int>(rows.size());
    rows.push_back(row);
  }
  if (rows.empty()) return false;
  BinaryEnergy energy(static_cast<int>(rows.size()));
  for (const int row : rows) {
    const int i = variable_of[row];
    const int label = labels_[row];
    energy.Add(i, OwnCost(row, plane) - OwnCost(row, label));
    for (const int other : (*companions_)[row]) {
      const int j = variable_of[other];
      const int its_label = labels_[other];
      if (j < 0) {
        energy.Add(i, PairCost(plane, its_label) - PairCost(label, its_label));
      } else if (row < other) {
        energy.Add(i, j, PairCost(label, its_label), PairCost(label, plane),
                   PairCost(plane, its_label), 0);
      }
    }
  }
  const std::vector<bool> moved = energy.Minimise();
  bool any = false;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (!moved[i]) continue;
    labels_[rows[i]] = plane;
    any = true;
  }
  return any;
}

// Drops matches that cost less without a plane, one after the other.
bool PlaneLabelling::Drop() {
  bool any = false;
  for (int row = 0; row < points_->size(); ++row) {
    if (labels_[row] == kNoPlane) continue;
    if (OwnCost(row, labels_[row]) + Disagreement(row) <= options_.outlier_cost) continue;
    labels_[row] = kNoPlane;
    any = true;
  }
  return any;
}

void PlaneLabelling::Refit(int p) {
  Labelled& plane = planes_[p];
  const std::vector<int> rows = RowsOf(p);
  if (plane.fixed || rows.size() < 5) return;
  std::vector<double> sigmas;
  for (const int row : rows) sigmas.push_back(plane.errors_px[row] / plane.sigma_px);
  const auto to_from = Fit(rows, sigmas);
  if (!to_from) return;
  plane.to_from = *to_from;
  Measure(plane);
  std::vector<float> errors;
  for (const int row : rows) errors.push_back(plane.errors_px[row]);
  SetSigma(plane, Median(std::move(errors)) / kRayleighMedian);
}

}  // namespace waystone
