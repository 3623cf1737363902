// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/fundamental.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "core/base/check.h"
#include "core/robust/false_alarms.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr size_t kMinPairs = 8;  // seven determine it

std::vector<cv::Point2d> ToCvPoints(std::span<const Vector2d> points) {
  std::vector<cv::Point2d> out;
  out.reserve(points.size());
  for (const Vector2d& x : points) out.emplace_back(x.x(), x.y());
  return out;
}

Matrix3d ToMatrix3d(const cv::Mat& matrix) {
  Matrix3d out;
  cv::cv2eigen(matrix, out);
  return out;
}

std::vector<int> FindEpipolarInliers(const Matrix3d& fundamental, std::span<const Vector2d> a,
                                     std::span<const Vector2d> b, double max_error_px) {
  std::vector<int> inliers;
  for (size_t i = 0; i < a.size(); ++i) {
    if (SampsonError(fundamental, a[i], b[i]) <= max_error_px) {
      inliers.push_back(static_cast<int>(i));
    }
  }
  return inliers;
}

// Of the rows, those that one homography explains; empty where none does.
std::vector<int> FindPlanarInliers(const std::vector<cv::Point2d>& a,
                                   const std::vector<cv::Point2d>& b, const std::vector<int>& rows,
                                   const EpipolarOptions& options) {
  std::vector<cv::Point2d> from;
  std::vector<cv::Point2d> to;
  for (const int row : rows) {
    from.push_back(a[row]);
    to.push_back(b[row]);
  }
  cv::Mat fits;
  const double bound = 2 * options.max_error_px;  // both coordinates have errors
  const cv::Mat homography = cv::findHomography(from, to, cv::USAC_MAGSAC, bound, fits,
                                                options.max_samples, options.confidence);
  std::vector<int> inliers;
  if (homography.empty()) return inliers;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (fits.at<uchar>(static_cast<int>(i))) inliers.push_back(rows[i]);
  }
  return inliers;
}

}  // namespace

void EpipolarOptions::Check() const { CheckFields("epipolar", *this); }

double SampsonError(const Matrix3d& fundamental, const Vector2d& x_a, const Vector2d& x_b) {
  const Vector3d line_b = fundamental * x_a.homogeneous();
  const Vector3d line_a = fundamental.transpose() * x_b.homogeneous();
  const double square = line_b.head<2>().squaredNorm() + line_a.head<2>().squaredNorm();
  return std::abs(x_b.homogeneous().dot(line_b)) / std::sqrt(square);
}

double EpipolarSignificance(int matches, int inliers, double max_error_px, int width, int height) {
  // Sampson's distance halves the square: each of two points moves, so the band is wider by sqrt 2.
  const double band = 2 * std::sqrt(2.0) * max_error_px;
  const double alpha = std::min(1.0, band * std::hypot(width, height) / (1.0 * width * height));
  return std::max(0.0, -LogFalseAlarms(matches, inliers, alpha, {.sample = 7, .solutions = 3}));
}

std::optional<EpipolarFit> FindEpipolarGeometry(std::span<const Vector2d> a,
                                                std::span<const Vector2d> b,
                                                const EpipolarOptions& options) {
  WS_CHECK(a.size() == b.size(), "pairs of points");
  if (a.size() < kMinPairs) return std::nullopt;
  const std::vector<cv::Point2d> from = ToCvPoints(a);
  const std::vector<cv::Point2d> to = ToCvPoints(b);
  cv::Mat fits;
  const cv::Mat found = cv::findFundamentalMat(from, to, cv::USAC_MAGSAC, options.max_error_px,
                                               options.confidence, options.max_samples, fits);
  if (found.rows != 3 || found.cols != 3) return std::nullopt;
  EpipolarFit fit;
  fit.fundamental = ToMatrix3d(found);
  fit.inliers = FindEpipolarInliers(fit.fundamental, a, b, options.max_error_px);
  if (fit.inliers.size() < kMinPairs) return std::nullopt;
  std::vector<int> planar = FindPlanarInliers(from, to, fit.inliers, options);
  if (static_cast<double>(planar.size()) >=
      options.planar_share * static_cast<double>(fit.inliers.size())) {
    fit.planar = true;
    fit.inliers = std::move(planar);
  }
  return fit;
}

}  // namespace waystone
