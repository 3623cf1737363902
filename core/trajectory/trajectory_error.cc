// SPDX-License-Identifier: Apache-2.0
#include "core/trajectory/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"

namespace waystone {
namespace {

using Pairs = std::vector<std::pair<size_t, size_t>>;

constexpr size_t kMinPairs = 3;

size_t NearestTime(const std::vector<double>& times_s, double time_s) {
  const auto after = std::lower_bound(times_s.begin(), times_s.end(), time_s);
  if (after == times_s.begin()) return 0;
  const auto before = after - 1;
  const bool take_before = after == times_s.end() || time_s - *before <= *after - time_s;
  return static_cast<size_t>((take_before ? before : after) - times_s.begin());
}

Pairs ByTime(const Trajectory& estimate, const Trajectory& truth, double max_difference_s) {
  Pairs pairs;
  for (size_t i = 0; i < estimate.times_s.size(); ++i) {
    const size_t k = NearestTime(truth.times_s, estimate.times_s[i]);
    if (std::abs(truth.times_s[k] - estimate.times_s[i]) <= max_difference_s)
      pairs.emplace_back(i, k);
  }
  return pairs;
}

Pairs ByOrder(size_t count) {
  Pairs pairs;
  for (size_t i = 0; i < count; ++i) pairs.emplace_back(i, i);
  return pairs;
}

double RootMeanSquare(const Points2& a, const Points2& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

Points2 Moved(const Points2& points, const Similarity2& by) {
  Points2 moved;
  for (const Eigen::Vector2d& point : points) moved.push_back(by * point);
  return moved;
}

void AddRelativeError(const Trajectory& estimate, const Trajectory& truth, const Pairs& pairs,
                      TrajectoryError& error) {
  double metres = 0;
  double radians = 0;
  for (size_t i = 1; i < pairs.size(); ++i) {
    const auto& [e0, t0] = pairs[i - 1];
    const auto& [e1, t1] = pairs[i];
    const Pose2 moved = Inverse(estimate.poses[e0]) * estimate.poses[e1];
    const Pose2 wrong = Inverse(Inverse(truth.poses[t0]) * truth.poses[t1]) * moved;
    metres += wrong.x * wrong.x + wrong.y * wrong.y;
    radians += wrong.theta_rad * wrong.theta_rad;
  }
  const auto steps = static_cast<double>(pairs.size() - 1);
  error.rpe_m = std::sqrt(metres / steps);
  error.rpe_rad = std::sqrt(radians / steps);
}

}  // namespace

void AssociationOptions::Check() const {
  if (max_difference_s > 0 && std::isfinite(max_difference_s)) return;
  throw MapError(ErrorCode::kBadOptions, "max_difference_s is " + std::to_string(max_difference_s) +
                                             "; it must be positive");
}

Pairs Associate(const Trajectory& estimate, const Trajectory& truth,
                const AssociationOptions& options) {
  options.Check();
  const bool timed = !estimate.times_s.empty() && !truth.times_s.empty();
  if (!timed && estimate.poses.size() != truth.poses.size()) {
    throw MapError(ErrorCode::kBadSource,
                   std::to_string(estimate.poses.size()) + " poses without time stamps for " +
                       std::to_string(truth.poses.size()) +
                       " true ones; both files need time stamps, or the same number of poses");
  }
  Pairs pairs =
      timed ? ByTime(estimate, truth, options.max_difference_s) : ByOrder(estimate.poses.size());
  if (pairs.size() >= kMinPairs) return pairs;
  throw MapError(ErrorCode::kBadSource,
                 "only " + std::to_string(pairs.size()) + " of " +
                     std::to_string(estimate.poses.size()) + " poses have a ground-truth pose" +
                     (timed ? " within " + std::to_string(options.max_difference_s) + " s" : "") +
                     "; at least 3 are required: check that both files are of the same run");
}

TrajectoryError CompareTrajectories(const Trajectory& estimate, const Trajectory& truth,
                                    const AssociationOptions& options) {
  const Pairs pairs = Associate(estimate, truth, options);
  Points2 estimated;
  Points2 expected;
  for (const auto& [e, t] : pairs) {
    estimated.emplace_back(estimate.poses[e].x, estimate.poses[e].y);
    expected.emplace_back(truth.poses[t].x, truth.poses[t].y);
  }
  TrajectoryError error;
  error.pairs = pairs.size();
  error.shape = CompareShapes(expected, estimated);
  error.ate_scaled_m = RootMeanSquare(expected, error.shape.aligned);
  const Similarity2 rigid = Align(expected, estimated, {.scale = false, .reflect = false});
  error.ate_m = RootMeanSquare(expected, Moved(estimated, rigid));
  if (estimate.has_headings && truth.has_headings) {
    AddRelativeError(estimate, truth, pairs, error);
  }
  return error;
}

}  // namespace waystone
