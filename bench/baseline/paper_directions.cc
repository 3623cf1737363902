// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/paper_directions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace waystone::bench {
namespace {

constexpr double kSameLine = 0.02;  // sine of the angle below which two normals have no crossing

struct VotedPoint {
  Eigen::Vector3d direction;
  int votes = 0;
};

std::vector<Eigen::Vector3d> LongestNormals(std::span<const GreatCircle> lines, int max_lines) {
  std::vector<const GreatCircle*> longest;
  for (const GreatCircle& line : lines) longest.push_back(&line);
  std::ranges::stable_sort(longest, std::greater<>(), &GreatCircle::length_rad);
  std::vector<Eigen::Vector3d> normals;
  for (const GreatCircle* line : longest) {
    if (static_cast<int>(normals.size()) == max_lines) break;
    normals.push_back(line->normal);
  }
  return normals;
}

// All putative vanishing points with their votes, most votes first.
std::vector<VotedPoint> VoteForPoints(const std::vector<Eigen::Vector3d>& normals,
                                      double max_error_rad) {
  const double bound = std::sin(max_error_rad);
  std::vector<VotedPoint> points;
  for (size_t i = 0; i < normals.size(); ++i) {
    for (size_t j = i + 1; j < normals.size(); ++j) {
      const Eigen::Vector3d cross = normals[i].cross(normals[j]);
      if (cross.norm() < kSameLine) continue;
      VotedPoint point{cross.normalized()};
      for (const Eigen::Vector3d& l : normals) {
        point.votes += std::abs(l.dot(point.direction)) < bound;
      }
      points.push_back(point);
    }
  }
  std::ranges::stable_sort(points, std::greater<>(), &VotedPoint::votes);
  return points;
}

}  // namespace

std::optional<Eigen::Matrix3d> FindDirectionsByVotes(std::span<const GreatCircle> lines,
                                                     double max_error_rad, double max_skew_rad,
                                                     int max_lines) {
  const std::vector<Eigen::Vector3d> normals = LongestNormals(lines, max_lines);
  if (normals.size() < 3) return std::nullopt;
  const std::vector<VotedPoint> points = VoteForPoints(normals, max_error_rad);
  if (points.empty()) return std::nullopt;
  const Eigen::Vector3d first = points.front().direction;
  const double skew = std::sin(max_skew_rad);
  const auto second = std::ranges::find_if(
      points, [&](const VotedPoint& point) { return std::abs(point.direction.dot(first)) < skew; });
  if (second == points.end()) return std::nullopt;
  Eigen::Matrix3d directions;
  directions.col(0) = first;
  directions.col(1) = (second->direction - first * first.dot(second->direction)).normalized();
  directions.col(2) = first.cross(directions.col(1));
  return directions;
}

}  // namespace waystone::bench
