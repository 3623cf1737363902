// SPDX-License-Identifier: Apache-2.0
#include "world/setting.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/option_range.h"
#include "core/base/random.h"

namespace waystone {
namespace {

constexpr double kStepM = 0.1;    // the paper's
constexpr double kHeightM = 0.9;  // of the camera on a robot

WorldOptions OfficeLook(uint64_t seed) {
  WorldOptions look;
  look.seed = seed;
  look.texture_richness = 0.5;
  return look;
}

// The camera looks along the trajectory: from the position before to the position after it.
void LookAlong(Walk& walk) {
  std::vector<Eigen::Vector3d> trajectory;
  for (const WalkFrame& frame : walk.frames) {
    trajectory.emplace_back(frame.world_from_camera.translation());
  }
  for (size_t i = 0; i < trajectory.size(); ++i) {
    const Eigen::Vector3d along =
        trajectory[std::min(i + 1, trajectory.size() - 1)] - trajectory[i == 0 ? 0 : i - 1];
    walk.frames[i].world_from_camera =
        WorldFromCamera(trajectory[i], std::atan2(along.y(), along.x()));
  }
}

// The first `frames` steps of a drive through waypoints (column, row).
Walk Drive(const FloorPlan& plan, const std::vector<Eigen::Vector2d>& waypoints, size_t frames) {
  WalkOptions options;
  options.height_m = kHeightM;
  options.step_m = kStepM;
  options.turn_rad = 1.0;  // bends don't slow it down: all steps are equal
  options.frame_rate = 2.0;
  options.gaze_rad = 0.0;
  options.sway = 0.0;
  options.rounding_m = 0.5;
  options.clearance_m = 0.25;
  Walk walk = WalkThrough(plan, waypoints, options);
  WS_CHECK(walk.frames.size() > frames,
           "the way is too short: " + std::to_string(walk.frames.size()) + " frames of " +
               std::to_string(frames));
  LookAlong(walk);
  walk.frames.resize(frames);
  return walk;
}

// On the ground the camera's z axis is the robot's x axis.
Pose2 GroundPose(const Eigen::Isometry3d& world_from_camera) {
  const Eigen::Vector3d centre = world_from_camera.translation();
  const Eigen::Vector3d gaze = world_from_camera.linear().col(2);
  return {centre.x(), centre.y(), std::atan2(gaze.y(), gaze.x())};
}

}  // namespace

Setting OfficeSetting() {
  const FloorPlan plan = ParseFloorPlan(R"(
##################
#.......##.......#
#.......DD.......#
#.......DD.......#
#.......DD.......#
#.......####.....#
#.......b###.....#
##DDD########DDD##
#...............##
#................#
#................#
#................#
#......####......#
##################
)");
  const Walk walk = Drive(
      plan, {{3.5, 5.5}, {3.5, 3.5}, {14.5, 3.5}, {14.5, 10.5}, {3.5, 10.5}, {3.5, 3.5}, {9, 3.5}},
      200);
  return {"office", plan, OfficeLook(11), walk};
}

Setting LaboratorySetting() {
  const FloorPlan plan = ParseFloorPlan(R"(
####################
#.......##.........#
#..................#
#..................#
#...........##.....#
#...###.....##....##
#...###...........##
#..................#
#..................#
#......##..........#
#......##...###....#
#..................#
#..................#
##......#..........#
####################
)");
  const Walk walk = Drive(
      plan, {{3, 11}, {3, 3.5}, {9, 3.5}, {10.5, 7.5}, {10.5, 10.5}, {9.5, 12}, {3, 12}, {3, 6}},
      150);
  return {"laboratory", plan, OfficeLook(12), walk};
}

Setting SettingByName(std::string_view name) {
  if (name == "office") return OfficeSetting();
  if (name == "laboratory") return LaboratorySetting();
  throw MapError(ErrorCode::kBadOptions,
                 "unknown setting \"" + std::string(name) + "\"; choose office or laboratory");
}

void OdometryOptions::Check() const {
  CheckRange("distance_noise", distance_noise, 0.0, 0.5);
  CheckRange("turn_noise", turn_noise, 0.0, 1.0);
  CheckRange("turn_bias", turn_bias, -1.0, 1.0);
}

std::vector<Pose2> GroundPoses(const Walk& walk) {
  std::vector<Pose2> poses;
  for (const WalkFrame& frame : walk.frames) poses.push_back(GroundPose(frame.world_from_camera));
  return poses;
}

std::vector<Pose2> WheelOdometry(const Walk& walk, const OdometryOptions& options) {
  options.Check();
  const std::vector<Pose2> truth = GroundPoses(walk);
  Random random(options.seed);
  std::vector<Pose2> poses;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (i == 0) {
      poses.emplace_back();
      continue;
    }
    Pose2 step = Inverse(truth[i - 1]) * truth[i];
    const double trajectory_m = std::hypot(step.x, step.y);
    const double slip = 1.0 + options.distance_noise * random.Normal();
    step.x *= slip;
    step.y *= slip;
    step.theta_rad += options.turn_bias * trajectory_m +
                      options.turn_noise * std::sqrt(trajectory_m) * random.Normal();
    poses.push_back(poses.back() * step);
  }
  return poses;
}

}  // namespace waystone
