// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/cube_rotations.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/rotation.h"

namespace waystone {
namespace {

std::array<Eigen::Matrix3d, 24> MakeCubeRotations() {
  std::array<Eigen::Matrix3d, 24> rotations;
  size_t count = 0;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d r = Eigen::Matrix3d::Zero();
      for (int i = 0; i < 3; ++i) r(order[i], i) = (signs >> i & 1) != 0 ? -1 : 1;
      if (r.determinant() > 0) rotations[count++] = r;
    }
  } while (std::ranges::next_permutation(order).found);
  return rotations;
}

}  // namespace

const std::array<Eigen::Matrix3d, 24>& CubeRotations() {
  static const std::array<Eigen::Matrix3d, 24> rotations = MakeCubeRotations();
  return rotations;
}

Eigen::Matrix3d NearestOfCube(const Eigen::Matrix3d& rig_from_axes,
                              const Eigen::Matrix3d& previous) {
  const Eigen::Matrix3d between = rig_from_axes.transpose() * previous;
  // tr(C^T between) is largest where the angle is smallest.
  const auto& all = CubeRotations();
  const auto best = std::ranges::max_element(
      all, {}, [&](const Eigen::Matrix3d& c) { return c.cwiseProduct(between).sum(); });
  return rig_from_axes * *best;
}

double CubeAngle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return RotationAngle(NearestOfCube(a, b), b);
}

double WorstAxisAngle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  double least = std::numbers::pi;
  for (const Eigen::Matrix3d& c : CubeRotations()) {
    const Eigen::Matrix3d turned = a * c;
    double worst = 0;
    for (int i = 0; i < 3; ++i) {
      const double sine = turned.col(i).cross(b.col(i)).norm();
      worst = std::max(worst, std::atan2(sine, turned.col(i).dot(b.col(i))));
    }
    least = std::min(least, worst);
  }
  return least;
}

}  // namespace waystone
