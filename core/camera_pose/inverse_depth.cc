// SPDX-License-Identifier: Apache-2.0
#include "core/camera_pose/inverse_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "core/geometry/tangent_basis.h"

namespace waystone {
namespace {

constexpr int kDepthSteps = 8;
constexpr double kDepthArrived = 1e-9;

// A sighting with what doesn't depend on the depth: x_camera, scaled by the inverse depth rho, is
// turned + rho * translation.
struct PreparedSighting {
  Eigen::Vector3d turned;
  Eigen::Vector3d translation;
  Eigen::Vector3d ray;
  Eigen::Matrix<double, 3, 2> basis;
  double sigma_rad;

  // In sigmas, on the image plane across the ray; infinite behind the camera.
  Eigen::Vector2d ErrorAt(double rho) const {
    const Eigen::Vector3d x = turned + rho * translation;
    const double ahead = ray.dot(x);
    if (!(ahead > 0)) return Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    return basis.transpose() * x / (ahead * sigma_rad);
  }
  Eigen::Vector2d SlopeAt(double rho) const {
    const Eigen::Vector3d x = turned + rho * translation;
    const double ahead = ray.dot(x);
    return (basis.transpose() * translation -
            basis.transpose() * x * (ray.dot(translation) / ahead)) /
           (ahead * sigma_rad);
  }
  // Where the sighting's ray comes nearest to the anchor's.
  double Guess() const {
    const Eigen::Vector2d step = basis.transpose() * translation;
    return -step.dot(basis.transpose() * turned) / step.squaredNorm();
  }
};

std::vector<PreparedSighting> PrepareSightings(const Eigen::Vector3d& anchor_ray,
                                               std::span<const RaySighting> sightings) {
  std::vector<PreparedSighting> prepared;
  for (const RaySighting& sighting : sightings) {
    prepared.push_back({sighting.camera_from_anchor.linear() * anchor_ray,
                        sighting.camera_from_anchor.translation(), sighting.ray,
                        TangentBasis(sighting.ray), sighting.sigma_rad});
  }
  return prepared;
}

double ScoreDepth(const std::vector<PreparedSighting>& sightings, double rho, double max_sigmas) {
  double score = 0;
  for (const PreparedSighting& one : sightings) {
    score += std::max(0.0, 1 - one.ErrorAt(rho).squaredNorm() / (max_sigmas * max_sigmas));
  }
  return score;
}

std::vector<const PreparedSighting*> Agreeing(const std::vector<PreparedSighting>& sightings,
                                              double rho, double max_sigmas) {
  std::vector<const PreparedSighting*> agreeing;
  for (const PreparedSighting& one : sightings) {
    if (one.ErrorAt(rho).squaredNorm() < max_sigmas * max_sigmas) agreeing.push_back(&one);
  }
  return agreeing;
}

// The hypothesis that most sightings agree on: one each, and infinity.
double FindInverseDepth(const std::vector<PreparedSighting>& sightings, double max_sigmas) {
  double rho = 0;
  double best = ScoreDepth(sightings, 0, max_sigmas);
  for (const PreparedSighting& one : sightings) {
    const double guess = one.Guess();
    if (!(guess > 0) || !std::isfinite(guess)) continue;
    const double score = ScoreDepth(sightings, guess, max_sigmas);
    if (score > best) std::tie(best, rho) = std::pair(score, guess);
  }
  return rho;
}

// Returns the information about the inverse depth, in squared sigmas.
double RefineInverseDepth(const std::vector<PreparedSighting>& sightings, double max_sigmas,
                          double& rho) {
  double information = 0;
  for (int step = 0; step < kDepthSteps; ++step) {
    double gradient = 0;
    information = 0;
    for (const PreparedSighting* one : Agreeing(sightings, rho, max_sigmas)) {
      const Eigen::Vector2d slope = one->SlopeAt(rho);
      information += slope.squaredNorm();
      gradient += slope.dot(one->ErrorAt(rho));
    }
    if (!(information > 0)) break;
    rho -= gradient / information;
    if (std::abs(gradient / information) < kDepthArrived * rho) break;
  }
  return information;
}

}  // namespace

DepthEstimate EstimateDepth(const Eigen::Vector3d& anchor_ray,
                            std::span<const RaySighting> sightings, const DepthOptions& options) {
  DepthEstimate estimate;
  if (std::ssize(sightings) < options.min_sightings) return estimate;
  const std::vector<PreparedSighting> prepared = PrepareSightings(anchor_ray, sightings);
  double rho = FindInverseDepth(prepared, options.max_sigmas);
  const double information = RefineInverseDepth(prepared, options.max_sigmas, rho);
  const auto agreeing = Agreeing(prepared, rho, options.max_sigmas);
  estimate.inliers = static_cast<int>(agreeing.size());
  for (const PreparedSighting* one : agreeing) estimate.error2 += one->ErrorAt(rho).squaredNorm();
  estimate.error = DepthError::kContradiction;
  if (estimate.inliers < options.min_sightings ||
      estimate.inliers < options.min_inlier_share * std::ssize(sightings)) {
    return estimate;
  }
  // Two coordinates a sighting; of the residuals' variance, 1 is expected.
  const double variance = (2 * options.prior_sightings + estimate.error2) /
                          (2 * options.prior_sightings + 2 * estimate.inliers - 1);
  estimate.relative_sigma = std::sqrt(variance / information) / rho;
  const bool known = rho > 0 && estimate.relative_sigma <= options.max_relative_sigma;
  estimate.error = known ? DepthError::kNone : DepthError::kUncertain;
  estimate.depth = known ? 1 / rho : 0;
  return estimate;
}

}  // namespace waystone
