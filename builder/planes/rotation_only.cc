// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/rotation_only.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/error.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The rotation that best aligns one set of directions with another (Kabsch).
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

// A pinhole camera with about as many pixels per radian in the middle of the image as this one.
Matrix3d PinholeOf(const Camera& camera) {
  const double focal = camera.model == CameraModel::kEquirectangular
                           ? camera.width / (2 * std::numbers::pi)
                           : camera.params[0];
  return Calibration(focal, 0.5 * (camera.width - 1), 0.5 * (camera.height - 1));
}

// The matches as seen by a pinhole camera `k` in the same place, without those farther than
// max_angle_rad from the optical axis, where it stretches noise without bounds.
MatchedPoints Undistorted(const MatchedPoints& points, const Camera& camera, const Matrix3d& k,
                          double max_angle_rad) {
  const double least_z = std::cos(max_angle_rad);
  MatchedPoints undistorted;
  for (int i = 0; i < points.size(); ++i) {
    const Vector3d from = Unproject(camera, points.from[i]);
    const Vector3d to = Unproject(camera, points.to[i]);
    if (from.z() < least_z || to.z() < least_z) continue;
    undistorted.from.emplace_back((k * from).hnormalized());
    undistorted.to.emplace_back((k * to).hnormalized());
  }
  return undistorted;
}

// Calibration matrices to try where the camera isn't known: a range of focal lengths.
std::vector<Matrix3d> Calibrations(int width, int height, const RotationOptions& options) {
  std::vector<Matrix3d> calibrations;
  const double longer = std::max(width, height);
  const double factor =
      std::pow(options.max_focal / options.min_focal, 1.0 / (options.focal_steps - 1));
  double share = options.min_focal;
  for (int step = 0; step < options.focal_steps; ++step) {
    calibrations.push_back(Calibration(share * longer, 0.5 * (width - 1), 0.5 * (height - 1)));
    share *= factor;
  }
  return calibrations;
}

// Whether one homography explains nearly all matches and, under one of the calibration matrices, a
// rotation does so as well.
bool IsRotation(const MatchedPoints& points, const std::vector<Matrix3d>& calibrations,
                const RotationOptions& options, const LocalRansacOptions& ransac, uint64_t seed) {
  // Samples from anywhere: a rotation's homography holds all over the image.
  LocalRansacOptions wide = ransac;
  wide.neighbourhood = std::max(3, points.size() - 1);
  const std::optional<PlaneFit> fit = FindPlane(points, wide, seed);
  if (!fit || fit->inliers.size() < options.min_share * static_cast<double>(points.size())) {
    return false;
  }
  // For two identical images only rounding is left, which means nothing.
  constexpr double kLeast_px = 1e-3;
  const double free =
      std::max(kLeast_px, std::sqrt(MeanError2(points, fit->inliers, fit->model.to_from)));
  return std::any_of(calibrations.begin(), calibrations.end(), [&](const Matrix3d& k) {
    return RotationError(points, fit->inliers, k) <= options.max_excess * free;
  });
}

}  // namespace

void RotationOptions::Check() const {
  CheckFields("rotation", *this);
  if (max_focal > min_focal) return;
  throw MapError(ErrorCode::kBadOptions, "rotation.max_focal must be above rotation.min_focal");
}

bool RotatesOnly(const MatchedPoints& points, int width, int height,
                 const std::optional<Camera>& camera, const RotationOptions& options,
                 const LocalRansacOptions& ransac, uint64_t seed) {
  if (!camera) {
    return IsRotation({points.from, points.to, {}}, Calibrations(width, height, options), options,
                      ransac, seed);
  }
  const Matrix3d k = PinholeOf(*camera);
  return IsRotation(Undistorted(points, *camera, k, options.max_angle_rad), {k}, options, ransac,
                    seed);
}

}  // namespace waystone
