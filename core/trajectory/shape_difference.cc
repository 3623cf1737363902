// SPDX-License-Identifier: Apache-2.0
#include "core/trajectory/shape_difference.h"

#include <Eigen/SVD>
#include <algorithm>
#include <string>

#include "core/base/error.h"

namespace waystone {
namespace {

// A spread below this share of the coordinates' size is rounding.
constexpr double kRounding = 1e-12;
// The squares of larger coordinates, and their sums, would not be finite.
constexpr double kMaxCoordinate = 1e100;

Eigen::Matrix2Xd MatrixOf(const Points2& points) {
  Eigen::Matrix2Xd matrix(2, points.size());
  for (size_t i = 0; i < points.size(); ++i) matrix.col(static_cast<Eigen::Index>(i)) = points[i];
  return matrix;
}

void CheckSpread(const Eigen::Matrix2Xd& points, const Eigen::Vector2d& mean,
                 const std::string& name) {
  if (!points.allFinite() || points.cwiseAbs().maxCoeff() > kMaxCoordinate) {
    throw MapError(ErrorCode::kBadSource,
                   "a point of the " + name + " is not finite; remove frames without a position");
  }
  const double spread = (points.colwise() - mean).cwiseAbs().maxCoeff();
  if (spread > kRounding * std::max(points.cwiseAbs().maxCoeff(), kRounding)) return;
  throw MapError(ErrorCode::kBadSource, "all " + std::to_string(points.cols()) + " points of the " +
                                            name +
                                            " coincide; the shape of a trajectory requires motion");
}

void CheckPairs(const Points2& truth, const Points2& estimate) {
  if (truth.size() != estimate.size()) {
    throw MapError(ErrorCode::kBadSource,
                   std::to_string(estimate.size()) + " points of the estimate for " +
                       std::to_string(truth.size()) + " of the truth; their numbers must be equal");
  }
  if (truth.size() >= 3) return;
  throw MapError(ErrorCode::kBadSource,
                 std::to_string(truth.size()) + " pairs of points; at least 3 are required");
}

}  // namespace

Similarity2 Align(const Points2& truth, const Points2& estimate, const AlignmentOptions& options) {
  CheckPairs(truth, estimate);
  const Eigen::Matrix2Xd a = MatrixOf(truth);
  const Eigen::Matrix2Xd c = MatrixOf(estimate);
  const Eigen::Vector2d a_mean = a.rowwise().mean();
  const Eigen::Vector2d c_mean = c.rowwise().mean();
  CheckSpread(a, a_mean, "truth");
  CheckSpread(c, c_mean, "estimate");
  const Eigen::Matrix2Xd c_centred = c.colwise() - c_mean;
  const Eigen::Matrix2d covariance = (a.colwise() - a_mean) * c_centred.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix2d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector2d signs = Eigen::Vector2d::Ones();
  const bool reflects = svd.matrixU().determinant() * svd.matrixV().determinant() < 0;
  if (reflects && !options.reflect) signs(1) = -1;  // the smaller singular value gives way
  Similarity2 result;
  result.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  if (options.scale) {
    result.scale = svd.singularValues().dot(signs) / c_centred.squaredNorm();
  }
  result.translation = a_mean - result.scale * (result.rotation * c_mean);
  return result;
}

ShapeDifference CompareShapes(const Points2& truth, const Points2& estimate) {
  ShapeDifference difference;
  difference.truth_from_estimate = Align(truth, estimate);
  const Eigen::Vector2d mean = MatrixOf(truth).rowwise().mean();
  double left = 0;
  double spread = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    difference.aligned.push_back(difference.truth_from_estimate * estimate[i]);
    left += (truth[i] - difference.aligned[i]).squaredNorm();
    spread += (truth[i] - mean).squaredNorm();
  }
  difference.mu = std::clamp(left / spread, 0.0, 1.0);
  return difference;
}

}  // namespace waystone
