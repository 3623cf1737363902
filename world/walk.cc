// SPDX-License-Identifier: Apache-2.0
#include "world/walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/geometry/angle.h"
#include "core/geometry/pose2.h"
#include "world/path.h"

namespace waystone {
namespace {

constexpr double kSway_m = 0.02;      // of the height, by a steady hand
constexpr double kMinHeight_m = 0.1;  // of the camera above the floor
constexpr double kSampleM = 0.02;     // spacing at which paths are sampled, finer than any frame's

// The camera's position and viewing direction at some length of the trajectory.
struct Sample {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;
  double trajectory_m = 0.0;
};

// The path's direction at every point, continuous (no jumps by 2 pi), averaged over `radius_m` so
// that the gaze follows a bend smoothly.
std::vector<double> Headings(const std::vector<Eigen::Vector2d>& trajectory, double radius_m) {
  std::vector<double> raw(trajectory.size(), 0.0);
  for (size_t i = 0; i + 1 < trajectory.size(); ++i) {
    const Eigen::Vector2d edge = trajectory[i + 1] - trajectory[i];
    const double angle = std::atan2(edge.y(), edge.x());
    raw[i] = i == 0 ? angle : raw[i - 1] + WrappedAngle(angle - raw[i - 1]);
  }
  if (raw.size() > 1) raw.back() = raw[raw.size() - 2];
  const auto reach = static_cast<std::ptrdiff_t>(radius_m / kSampleM);
  const auto last = static_cast<std::ptrdiff_t>(raw.size()) - 1;
  std::vector<double> smooth = raw;
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    double sum = 0.0;
    for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
      sum += raw[static_cast<size_t>(std::clamp(i + k, std::ptrdiff_t{0}, last))];
    }
    smooth[static_cast<size_t>(i)] = sum / static_cast<double>(2 * reach + 1);
  }
  return smooth;
}

std::vector<Sample> GazeAlong(const std::vector<Eigen::Vector2d>& trajectory,
                              const WalkOptions& options) {
  const std::vector<double> headings = Headings(trajectory, 2.0 * options.rounding_m);
  std::vector<Sample> samples;
  double trajectory_m = 0.0;
  for (size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0) trajectory_m += (trajectory[i] - trajectory[i - 1]).norm();
    const double swing =
        options.gaze_rad * std::sin(2.0 * kPi * trajectory_m / options.gaze_period_m);
    samples.push_back({trajectory[i], headings[i] + options.gaze_offset_rad + swing, trajectory_m});
  }
  return samples;
}

// Inserts a turn on the spot and back into the middle of the trajectory.
void TurnOnSpot(const WalkOptions& options, std::vector<Sample>& samples) {
  const double angle = options.turn_on_spot_rad;
  if (angle == 0.0) return;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(angle) / options.turn_rad)));
  const size_t middle = samples.size() / 2;
  std::vector<Sample> turn;
  for (int i = 1; i <= 2 * steps; ++i) {
    Sample sample = samples[middle];
    sample.yaw_rad += angle * (i <= steps ? i : 2 * steps - i) / steps;
    turn.push_back(sample);
  }
  samples.insert(samples.begin() + static_cast<std::ptrdiff_t>(middle) + 1, turn.begin(),
                 turn.end());
}

// Frames such that from one to the next neither the step nor the turn is longer than allowed.
std::vector<Sample> AtFrames(const std::vector<Sample>& samples, const WalkOptions& options) {
  std::vector<Sample> frames = {samples.front()};
  double due = 1.0;  // in frames: when the next one is
  double spent = 0.0;
  for (size_t i = 1; i < samples.size(); ++i) {
    const Sample& from = samples[i - 1];
    const Sample& to = samples[i];
    const double cost = std::max((to.point - from.point).norm() / options.step_m,
                                 std::abs(to.yaw_rad - from.yaw_rad) / options.turn_rad);
    for (; spent + cost >= due; due += 1.0) {
      const double share = cost > 0.0 ? (due - spent) / cost : 0.0;
      frames.push_back({from.point + share * (to.point - from.point),
                        from.yaw_rad + share * (to.yaw_rad - from.yaw_rad),
                        from.trajectory_m + share * (to.trajectory_m - from.trajectory_m)});
    }
    spent += cost;
  }
  return frames;
}

// The sway of a walking person's hand: two waves each for height, pitch and roll.
class Hand {
 public:
  explicit Hand(const WalkOptions& options) : factor_(options.sway) {
    Random random(options.seed);
    for (double& phase : phases_) phase = random.Uniform(0.0, 2.0 * kPi);
  }
  double Height(double trajectory_m) const { return factor_ * kSway_m * Wave(0, trajectory_m); }
  double Pitch(double trajectory_m) const { return factor_ * kPitchRad * Wave(2, trajectory_m); }
  double Roll(double trajectory_m) const { return factor_ * kRollRad * Wave(4, trajectory_m); }

 private:
  static constexpr double kPitchRad = 2.0 * kPi / 180.0;
  static constexpr double kRollRad = 1.0 * kPi / 180.0;

  double Wave(size_t first, double trajectory_m) const {
    constexpr double kStrideM = 1.4;
    constexpr double kSlowM = 4.7;
    return 0.4 * std::sin(2.0 * kPi * trajectory_m / kStrideM + phases_[first]) +
           0.6 * std::sin(2.0 * kPi * trajectory_m / kSlowM + phases_[first + 1]);
  }

  double factor_;
  std::array<double, 6> phases_{};
};

void CheckTrajectory(const FloorPlan& plan, const std::vector<Eigen::Vector2d>& trajectory) {
  for (const Eigen::Vector2d& point : trajectory) {
    if (plan.IsFree(point, 0.0)) continue;
    const int column = static_cast<int>(std::floor(point.x() / plan.size.cell_m));
    const int row = plan.rows - 1 - static_cast<int>(std::floor(point.y() / plan.size.cell_m));
    throw MapError(ErrorCode::kBadOptions,
                   "the walk meets a wall of the floor plan at line " + std::to_string(row + 1) +
                       ", column " + std::to_string(column + 1) +
                       "; put waypoints on floor and before and after doors");
  }
}

Walk WalkAlong(const FloorPlan& plan, const std::vector<Eigen::Vector2d>& line,
               const WalkOptions& options) {
  const std::vector<Eigen::Vector2d> fine = Resampled(line, kSampleM);
  CheckTrajectory(plan, fine);
  const std::vector<Eigen::Vector2d> trajectory =
      Smoothed(plan, fine, kSampleM, options.rounding_m, options.clearance_m);
  CheckTrajectory(plan, trajectory);
  std::vector<Sample> samples = GazeAlong(trajectory, options);
  TurnOnSpot(options, samples);
  const Hand hand(options);
  Walk walk;
  for (const Sample& frame : AtFrames(samples, options)) {
    const Eigen::Vector3d centre(frame.point.x(), frame.point.y(),
                                 options.height_m + hand.Height(frame.trajectory_m));
    walk.frames.push_back({static_cast<double>(walk.frames.size()) / options.frame_rate,
                           WorldFromCamera(centre, frame.yaw_rad, hand.Pitch(frame.trajectory_m),
                                           hand.Roll(frame.trajectory_m))});
  }
  return walk;
}

// A loop around a stop, as wide as the room allows up to `kLoopM`, entered where the trajectory
// comes from.
void AddLoop(const FloorPlan& plan, const Eigen::Vector2d& stop, const Eigen::Vector2d& from,
             double clearance_m, std::vector<Eigen::Vector2d>& line) {
  constexpr double kLoopM = 0.8;
  constexpr int kCorners = 8;
  const double start = std::atan2(from.y() - stop.y(), from.x() - stop.x());
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = start + 2.0 * kPi * i / kCorners;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    double radius = kLoopM;
    while (radius > kSampleM && !plan.IsFree(stop + radius * direction, clearance_m)) {
      radius -= kSampleM;
    }
    line.emplace_back(stop + radius * direction);
  }
}

// Throws where the camera, with the hand's sway, would reach above the lintels.
void CheckHeight(const FloorPlan& plan, const WalkOptions& options) {
  const double highest_m = options.height_m + kSway_m * options.sway;
  if (highest_m <= plan.size.door_height_m) return;
  throw MapError(ErrorCode::kBadOptions, "walk.height_m with its sway reaches " +
                                             std::to_string(highest_m) +
                                             " m; it must be below the lintels at " +
                                             std::to_string(plan.size.door_height_m) + " m");
}

}  // namespace

void WalkOptions::Check() const {
  CheckFields("walk", *this);
  if (height_m >= kMinHeight_m + kSway_m * sway) return;
  throw MapError(ErrorCode::kBadOptions, "walk.height_m is " + std::to_string(height_m) +
                                             "; with its sway it must stay " +
                                             std::to_string(kMinHeight_m) + " m above the floor");
}

Eigen::Isometry3d WorldFromCamera(const Eigen::Vector3d& centre, double yaw_rad, double pitch_rad,
                                  double roll_rad) {
  Eigen::Matrix3d level;  // looking east: right is south, down is down
  level << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() * level *
                  Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitX()).toRotationMatrix() *
                  Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = centre;
  return pose;
}

Walk WalkThrough(const FloorPlan& plan, const std::vector<Eigen::Vector2d>& waypoints,
                 const WalkOptions& options) {
  options.Check();
  CheckHeight(plan, options);
  if (waypoints.size() < 2) {
    throw MapError(ErrorCode::kBadOptions, "a walk of " + std::to_string(waypoints.size()) +
                                               " waypoints; it needs at least 2");
  }
  std::vector<Eigen::Vector2d> line;
  for (const Eigen::Vector2d& point : waypoints) {
    line.emplace_back(plan.size.cell_m * Eigen::Vector2d(point.x(), plan.rows - point.y()));
  }
  return WalkAlong(plan, line, options);
}

Walk DemoWalk(const FloorPlan& plan, const WalkOptions& options) {
  options.Check();
  CheckHeight(plan, options);
  if (plan.stops.size() < 2) {
    throw MapError(ErrorCode::kBadOptions, "the floor plan has " +
                                               std::to_string(plan.stops.size()) +
                                               " stops; mark at least 2 on its floor, '1' and '2'");
  }
  std::vector<Eigen::Vector2d> line;
  for (size_t i = 0; i < plan.stops.size(); ++i) {
    const Eigen::Vector2i& to = plan.stops[(i + 1) % plan.stops.size()];
    const std::vector<Eigen::Vector2i> path = FindPath(plan, plan.stops[i], to);
    // The cells next to a stop belong to its loop.
    for (size_t k = i == 0 ? 0 : 2; k + 2 < path.size(); ++k)
      line.push_back(plan.CentreOf(path[k]));
    if (i + 1 < plan.stops.size() && !line.empty()) {
      AddLoop(plan, plan.CentreOf(to), line.back(), options.clearance_m, line);
    }
  }
  line.push_back(plan.CentreOf(plan.stops.front()));
  return WalkAlong(plan, line, options);
}

}  // namespace waystone
