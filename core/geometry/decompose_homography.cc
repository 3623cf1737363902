// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/decompose_homography.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

namespace waystone {
namespace {

constexpr double kRankOne = 1e-12;  // middle singular value, as a share of the largest

// Of a matrix that is nearly a multiple of a rotation.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& h) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(h, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d r = svd.matrixU() * svd.matrixV().transpose();
  return r.determinant() < 0 ? Eigen::Matrix3d(-r) : r;
}

}  // namespace

// With H^T H = V diag(s1^2, 1, s3^2) V^T the unit vectors u whose length H preserves span two
// planes with v2, and R maps (v2, u, v2 x u) to (H v2, H u, H v2 x H u).
std::vector<PlaneMotion> DecomposeHomography(const Eigen::Matrix3d& b_from_a,
                                             double rotation_tolerance) {
  if (!b_from_a.allFinite()) return {};
  const Eigen::Vector3d values = Eigen::JacobiSVD<Eigen::Matrix3d>(b_from_a).singularValues();
  if (!(values(1) > kRankOne * values(0))) return {};
  const Eigen::Matrix3d h = b_from_a * (1 / values(1));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(h.transpose() * h);
  const double s3 = solver.eigenvalues()(0);
  const double s1 = solver.eigenvalues()(2);
  if (s1 - s3 < rotation_tolerance || s1 < 1 || s3 > 1) return {{.b_from_a = NearestRotation(h)}};
  const Eigen::Vector3d v1 = solver.eigenvectors().col(2);
  const Eigen::Vector3d v2 = solver.eigenvectors().col(1);
  const Eigen::Vector3d v3 = solver.eigenvectors().col(0);
  std::vector<PlaneMotion> motions;
  for (const int sign : {1, -1}) {
    const Eigen::Vector3d u =
        (std::sqrt(1 - s3) * v1 + sign * std::sqrt(s1 - 1) * v3) / std::sqrt(s1 - s3);
    Eigen::Matrix3d from;
    from << v2, u, v2.cross(u);
    Eigen::Matrix3d to;
    to << h * v2, h * u, (h * v2).cross(h * u);
    PlaneMotion motion;
    motion.b_from_a = to * from.transpose();
    motion.normal = from.col(2);
    motion.translation = (h - motion.b_from_a) * motion.normal;
    motions.push_back(motion);
  }
  return motions;
}

}  // namespace waystone
