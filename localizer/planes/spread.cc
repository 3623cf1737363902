// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/spread.h"

#include <algorithm>
#include <set>
#include <utility>

namespace waystone {
namespace {

using Eigen::Vector2d;

constexpr int kCoverageCells = 5;  // a side

}  // namespace

bool CanShow(const Features& image, const Vector2d& x) {
  constexpr double kMargin = 0.05;  // of the image
  const Vector2d size(image.width, image.height);
  const Vector2d margin = kMargin * size;
  return (x.array() >= margin.array()).all() &&  // not for NaN
         (x.array() < (size - margin).array()).all() && !IsClipped(image, x);
}

int CountApart(const std::vector<Vector2d>& points, double apart) {
  std::vector<Vector2d> counted;
  for (const Vector2d& x : points) {
    const bool near = std::any_of(counted.begin(), counted.end(), [&](const Vector2d& other) {
      return (other - x).squaredNorm() < apart * apart;
    });
    if (!near) counted.push_back(x);
  }
  return static_cast<int>(counted.size());
}

double ComputeCoverage(const std::vector<Vector2d>& points, int width, int height) {
  std::set<std::pair<int, int>> cells;
  for (const Vector2d& x : points) {
    cells.emplace(static_cast<int>(kCoverageCells * x.x() / width),
                  static_cast<int>(kCoverageCells * x.y() / height));
  }
  return static_cast<double>(cells.size()) / (kCoverageCells * kCoverageCells);
}

}  // namespace waystone
