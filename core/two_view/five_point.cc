// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/five_point.h"

#include <Eigen/Dense>
#include <algorithm>
#include <opencv2/calib3d.hpp>

namespace waystone {
namespace {

using Rays = std::array<Eigen::Vector3d, 5>;

// OpenCV's solver takes points of the plane z = 1. x_b^T E x_a = 0 doesn't mind signs, so a ray
// backwards is the point it pierces the plane in when prolonged; only rays along the plane have
// none. So the rays are turned to the view, of these, that keeps all of them farthest from it.
std::array<Eigen::Matrix3d, 13> MakeViews() {
  std::array<Eigen::Matrix3d, 13> views;
  size_t count = 0;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = 0; z <= 1; ++z) {
        // Half of the 26 directions of a cube: faces, edges, corners.
        if (z == 0 && (x < 0 || (x == 0 && y <= 0))) continue;
        const Eigen::Vector3d forward = Eigen::Vector3d(x, y, z).normalized();
        const Eigen::Vector3d right = forward.unitOrthogonal();
        views[count++] << right.transpose(), forward.cross(right).transpose(), forward.transpose();
      }
    }
  }
  return views;
}

double LeastDepth(const Eigen::Matrix3d& view, const Rays& rays) {
  double least = 1;
  for (const Eigen::Vector3d& ray : rays) least = std::min(least, std::abs(view.row(2).dot(ray)));
  return least;
}

const Eigen::Matrix3d& BestView(const Rays& rays) {
  static const std::array<Eigen::Matrix3d, 13> views = MakeViews();
  return *std::ranges::max_element(
      views, {}, [&](const Eigen::Matrix3d& view) { return LeastDepth(view, rays); });
}

cv::Mat PlanePoints(const Eigen::Matrix3d& view, const Rays& rays) {
  cv::Mat points(5, 2, CV_64F);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d turned = view * rays[i];
    points.at<double>(i, 0) = turned.x() / turned.z();
    points.at<double>(i, 1) = turned.y() / turned.z();
  }
  return points;
}

}  // namespace

std::vector<Eigen::Matrix3d> SolveFivePoints(const Rays& a, const Rays& b) {
  const Eigen::Matrix3d& view_a = BestView(a);
  const Eigen::Matrix3d& view_b = BestView(b);
  // Of exactly five points OpenCV gives all solutions, and draws no sample.
  const cv::Mat stacked = cv::findEssentialMat(PlanePoints(view_a, a), PlanePoints(view_b, b),
                                               cv::Mat::eye(3, 3, CV_64F));
  std::vector<Eigen::Matrix3d> solutions;
  for (int row = 0; row + 3 <= stacked.rows; row += 3) {
    Eigen::Matrix3d e;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) e(i, j) = stacked.at<double>(row + i, j);
    }
    if (e.allFinite()) solutions.emplace_back(view_b.transpose() * e * view_a);
  }
  return solutions;
}

std::array<Motion, 4> DecomposeEssential(const Eigen::Matrix3d& essential) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  Eigen::Matrix3d v = svd.matrixV();
  if (u.determinant() < 0) u = -u;
  if (v.determinant() < 0) v = -v;
  Eigen::Matrix3d w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d one = u * w * v.transpose();
  const Eigen::Matrix3d other = u * w.transpose() * v.transpose();
  const Eigen::Vector3d t = u.col(2);
  return {{{one, t}, {one, -t}, {other, t}, {other, -t}}};
}

}  // namespace waystone
