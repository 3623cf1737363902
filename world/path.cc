// SPDX-License-Identifier: Apache-2.0
#include "world/path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace waystone {
namespace {

// A step beside a wall costs as much as this many in the open.
constexpr double kWallCost = 4.0;

class Search {
 public:
  Search(const FloorPlan& plan, const Eigen::Vector2i& from)
      : plan_(plan),
        cost_(static_cast<size_t>(plan.columns) * static_cast<size_t>(plan.rows),
              std::numeric_limits<double>::infinity()),
        parent_(cost_.size(), -1) {
    cost_[Index(from)] = 0.0;
    queue_.emplace(0.0, Index(from));
    while (!queue_.empty()) {
      const auto [cost, index] = queue_.top();
      queue_.pop();
      if (cost <= cost_[index]) Expand(index);
    }
  }

  std::vector<Eigen::Vector2i> PathTo(const Eigen::Vector2i& to) const {
    if (!std::isfinite(cost_[Index(to)])) return {};
    std::vector<Eigen::Vector2i> path;
    for (auto i = static_cast<int64_t>(Index(to)); i >= 0; i = parent_[static_cast<size_t>(i)]) {
      path.push_back(CellOf(static_cast<size_t>(i)));
    }
    std::reverse(path.begin(), path.end());
    return path;
  }

 private:
  size_t Index(const Eigen::Vector2i& cell) const {
    return static_cast<size_t>(cell.y()) * static_cast<size_t>(plan_.columns) +
           static_cast<size_t>(cell.x());
  }
  Eigen::Vector2i CellOf(size_t index) const {
    const auto columns = static_cast<size_t>(plan_.columns);
    return {static_cast<int>(index % columns), static_cast<int>(index / columns)};
  }

  bool IsBesideWall(const Eigen::Vector2i& cell) const {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!plan_.IsOpen(cell.x() + dx, cell.y() + dy)) return true;
      }
    }
    return false;
  }

  void Expand(size_t index) {
    const Eigen::Vector2i cell = CellOf(index);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Eigen::Vector2i next(cell.x() + dx, cell.y() + dy);
        // A diagonal step needs both cells beside it: no cutting of corners.
        if (!plan_.IsOpen(next.x(), next.y()) || !plan_.IsOpen(next.x(), cell.y()) ||
            !plan_.IsOpen(cell.x(), next.y())) {
          continue;
        }
        const double length = std::sqrt(static_cast<double>(dx * dx + dy * dy));
        const double cost = cost_[index] + length * (IsBesideWall(next) ? kWallCost : 1.0);
        if (cost >= cost_[Index(next)]) continue;
        cost_[Index(next)] = cost;
        parent_[Index(next)] = static_cast<int64_t>(index);
        queue_.emplace(cost, Index(next));
      }
    }
  }

  using Entry = std::pair<double, size_t>;
  const FloorPlan& plan_;
  std::vector<double> cost_;
  std::vector<int64_t> parent_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

// Whether a point may move: it keeps the clearance, or as much of it as it has.
bool KeepsClear(const FloorPlan& plan, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                double clearance_m) {
  constexpr int kLevels = 10;
  for (int level = kLevels; level >= 0; --level) {
    const double clearance = clearance_m * level / kLevels;
    if (plan.IsFree(to, clearance)) return true;
    if (plan.IsFree(from, clearance)) return false;
  }
  return true;
}

std::string NameOfCell(const Eigen::Vector2i& cell) {
  return "line " + std::to_string(cell.y() + 1) + ", column " + std::to_string(cell.x() + 1);
}

}  // namespace

std::vector<Eigen::Vector2i> FindPath(const FloorPlan& plan, const Eigen::Vector2i& from,
                                      const Eigen::Vector2i& to) {
  for (const Eigen::Vector2i& cell : {from, to}) {
    if (plan.IsOpen(cell.x(), cell.y())) continue;
    throw MapError(ErrorCode::kBadOptions,
                   "the plan has no floor at " + NameOfCell(cell) + "; walk over open cells");
  }
  std::vector<Eigen::Vector2i> path = Search(plan, from).PathTo(to);
  if (path.empty()) {
    throw MapError(ErrorCode::kBadOptions, "the plan has no way from " + NameOfCell(from) + " to " +
                                               NameOfCell(to) + "; add a door (D)");
  }
  return path;
}

std::vector<Eigen::Vector2d> Resampled(const std::vector<Eigen::Vector2d>& line, double step_m) {
  std::vector<Eigen::Vector2d> points;
  for (size_t i = 0; i + 1 < line.size(); ++i) {
    const Eigen::Vector2d edge = line[i + 1] - line[i];
    const int steps = std::max(1, static_cast<int>(std::ceil(edge.norm() / step_m)));
    if (edge.isZero()) continue;
    for (int k = 0; k < steps; ++k) points.emplace_back(line[i] + edge * k / steps);
  }
  if (!line.empty()) points.push_back(line.back());
  return points;
}

std::vector<Eigen::Vector2d> Smoothed(const FloorPlan& plan, std::vector<Eigen::Vector2d> line,
                                      double step_m, double radius_m, double clearance_m) {
  // Averaging with both neighbours n times blurs over about step * sqrt(n / 2).
  const auto rounds = static_cast<int>(2.0 * radius_m * radius_m / (step_m * step_m));
  for (int round = 0; round < rounds; ++round) {
    std::vector<Eigen::Vector2d> next = line;
    for (size_t i = 1; i + 1 < line.size(); ++i) {
      const Eigen::Vector2d point = 0.25 * line[i - 1] + 0.5 * line[i] + 0.25 * line[i + 1];
      if (KeepsClear(plan, line[i], point, clearance_m)) next[i] = point;
    }
    line = std::move(next);
  }
  return line;
}

}  // namespace waystone
