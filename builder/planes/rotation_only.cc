// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/rotation_only.h"

#include <Eigen/Dense>
#include <cmath>
#include <numeric>

#include "core/base/error.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The rotation that turns one set of directions best into another (Kabsch).
Matrix3d BestRotation(const std::vector<Vector3d>& from, const std::vector<Vector3d>& to) {
  Matrix3d correlation = Matrix3d::Zero();
  for (size_t i = 0; i < from.size(); ++i) correlation += to[i] * from[i].transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

std::vector<Vector3d> Directions(const std::vector<Eigen::Vector2d>& pixels,
                                 std::span<const int> rows, const Matrix3d& inverse_k) {
  std::vector<Vector3d> directions;
  directions.reserve(rows.size());
  for (int row : rows) directions.push_back((inverse_k * pixels[row].homogeneous()).normalized());
  return directions;
}

double MeanError2(const MatchedPoints& points, std::span<const int> rows, const Matrix3d& to_from) {
  const Matrix3d from_to = to_from.inverse();
  double sum = 0;
  for (int row : rows) {
    sum += SymmetricTransferError2(to_from, from_to, points.from[row], points.to[row]);
  }
  return sum / static_cast<double>(rows.size());
}

// Root mean square error of the best rotation under a calibration matrix, px.
double RotationError(const MatchedPoints& points, std::span<const int> rows, const Matrix3d& k) {
  const Matrix3d inverse = k.inverse();
  const Matrix3d rotation =
      BestRotation(Directions(points.from, rows, inverse), Directions(points.to, rows, inverse));
  return std::sqrt(MeanError2(points, rows, k * rotation * inverse));
}

Matrix3d Calibration(double f, double cx, double cy) {
  Matrix3d k;
  k << f, 0, cx, 0, f, cy, 0, 0, 1;
  return k;
}

// Calibration matrices to try: the camera's own, or a range of focal lengths.
std::vector<Matrix3d> Calibrations(int width, int height, const std::optional<Camera>& camera,
                                   const RotationOptions& options) {
  if (camera && camera->model == CameraModel::kPinhole) {
    Matrix3d k = Calibration(camera->params[0], camera->params[2], camera->params[3]);
    k(1, 1) = camera->params[1];
    return {k};
  }
  std::vector<Matrix3d> calibrations;
  const double longer = std::max(width, height);
  const double factor =
      std::pow(options.max_focal / options.min_focal, 1.0 / (options.focal_steps - 1));
  double share = options.min_focal;
  for (int step = 0; step < options.focal_steps; ++step, share *= factor) {
    calibrations.push_back(Calibration(share * longer, 0.5 * (width - 1), 0.5 * (height - 1)));
  }
  return calibrations;
}

}  // namespace

void RotationOptions::Check() const {
  const bool good = min_share > 0 && min_share <= 1 && max_excess >= 1 && min_focal > 0 &&
                    max_focal > min_focal && focal_steps >= 2;
  if (!good) {
    throw MapError(ErrorCode::kBadOptions,
                   "rotation: an option is out of its range; leave them at their defaults");
  }
}

bool RotatesOnly(const MatchedPoints& points, int width, int height,
                 const std::optional<Camera>& camera, const RotationOptions& options,
                 const LocalRansacOptions& ransac, uint64_t seed) {
  std::vector<int> all(points.size());
  std::iota(all.begin(), all.end(), 0);
  // Samples from anywhere: a rotation's homography holds all over the image.
  LocalRansacOptions wide = ransac;
  wide.neighbourhood = std::max(3, points.size() - 1);
  const Neighbourhoods neighbourhoods(points.from, wide.neighbourhood);
  const MatchedPoints pair{points.from, points.to, {}};
  Random random(seed);
  const std::optional<PlaneFit> fit = FindPlane(pair, all, neighbourhoods, wide, random);
  if (!fit || fit->inliers.size() < options.min_share * static_cast<double>(all.size())) {
    return false;
  }
  const double free = std::sqrt(MeanError2(pair, fit->inliers, fit->model.to_from));
  for (const Matrix3d& k : Calibrations(width, height, camera, options)) {
    if (RotationError(pair, fit->inliers, k) <= options.max_excess * free) return true;
  }
  return false;
}

}  // namespace waystone
