// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/spread.h"

#include <algorithm>
#include <cmath>
#include <map>
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
  if (!(apart > 0)) return static_cast<int>(points.size());
  using Cell = std::pair<double, double>;
  std::map<Cell, std::vector<Vector2d>> counted;  // by cells of that side: a few in each
  const auto is_near = [&](const Vector2d& x, const Cell& cell) {
    const auto found = counted.find(cell);
    return found != counted.end() && std::ranges::any_of(found->second, [&](const Vector2d& other) {
             return (other - x).squaredNorm() < apart * apart;
           });
  };
  int count = 0;
  for (const Vector2d& x : points) {
    const Cell cell(std::floor(x.x() / apart), std::floor(x.y() / apart));
    bool near = false;
    for (const double right : {-1.0, 0.0, 1.0}) {
      for (const double down : {-1.0, 0.0, 1.0}) {
        near = near || is_near(x, {cell.first + right, cell.second + down});
      }
    }
    if (near) continue;
    counted[cell].push_back(x);
    ++count;
  }
  return count;
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
