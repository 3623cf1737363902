// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/paper_motion.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/robust/lo_ransac.h"
#include "core/two_view/relative_rotation.h"

namespace waystone::bench {
namespace {

constexpr int kSample = 8;
constexpr double kConfidence = 0.999;

// The essential matrix of these rows, x_b^T E x_a = 0, by the eight-point algorithm: its singular
// values are made 1, 1 and 0.
Eigen::Matrix3d SolveEightPoints(const MatchedRays& rays, const std::vector<int>& rows) {
  Eigen::MatrixXd equations(rows.size(), 9);
  for (size_t i = 0; i < rows.size(); ++i) {
    const Eigen::Vector3d& a = rays.a[rows[i]];
    const Eigen::Vector3d& b = rays.b[rows[i]];
    for (int k = 0; k < 3; ++k) equations.block<1, 3>(i, 3 * k) = b(k) * a.transpose();
  }
  const Eigen::Matrix<double, 9, 9> normal = equations.transpose() * equations;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
  const Eigen::Matrix<double, 9, 1> e = solver.eigenvectors().col(0);
  const Eigen::Matrix3d linear =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(e.data());
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * Eigen::Vector3d(1, 1, 0).asDiagonal() * svd.matrixV().transpose();
}

// The error is the same for all four motions of an essential matrix.
std::vector<int> FindInliers(const MatchedRays& rays, const Motion& motion, double max_error_rad) {
  std::vector<int> inliers;
  for (int i = 0; i < rays.size(); ++i) {
    const double error = EpipolarError(motion.b_from_a, motion.translation, rays.a[i], rays.b[i]);
    if (error < max_error_rad) inliers.push_back(i);
  }
  return inliers;
}

// Whether the point that both rays see lies ahead in both views.
bool IsAhead(const Motion& motion, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d ra = motion.b_from_a * a;
  const Eigen::Vector3d parallax = ra.cross(b);
  return motion.translation.cross(b).dot(parallax) < 0 &&
         motion.translation.cross(ra).dot(parallax) < 0;
}

std::vector<int> DrawRows(int rows, Random& random) {
  std::vector<int> sample;
  while (sample.size() < kSample) {
    const int row = random.Below(rows);
    if (std::ranges::find(sample, row) == sample.end()) sample.push_back(row);
  }
  return sample;
}

}  // namespace

std::optional<PaperMotion> FindMotionByEightPoints(const MatchedRays& rays, double max_error_rad,
                                                   int min_inliers, int max_samples,
                                                   uint64_t seed) {
  if (rays.size() < std::max(kSample, min_inliers)) return std::nullopt;
  Random random(seed);
  std::vector<int> best;
  double needed = max_samples;
  for (int sample = 0; sample < needed; ++sample) {
    const auto motions = DecomposeEssential(SolveEightPoints(rays, DrawRows(rays.size(), random)));
    std::vector<int> inliers = FindInliers(rays, motions.front(), max_error_rad);
    if (inliers.size() <= best.size()) continue;
    best = std::move(inliers);
    const double share = static_cast<double>(best.size()) / rays.size();
    needed = std::min<double>(max_samples, SamplesNeeded(kConfidence, std::pow(share, kSample)));
  }
  if (static_cast<int>(best.size()) < std::max(kSample, min_inliers)) return std::nullopt;
  const auto motions = DecomposeEssential(SolveEightPoints(rays, best));
  PaperMotion found{{}, FindInliers(rays, motions.front(), max_error_rad)};
  if (static_cast<int>(found.inliers.size()) < min_inliers) return std::nullopt;
  int most = -1;
  for (const Motion& motion : motions) {
    const auto ahead = static_cast<int>(std::ranges::count_if(
        found.inliers, [&](int i) { return IsAhead(motion, rays.a[i], rays.b[i]); }));
    if (ahead <= most) continue;
    most = ahead;
    found.motion = motion;
  }
  return found;
}

}  // namespace waystone::bench
