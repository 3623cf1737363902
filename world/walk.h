// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "world/floor_plan.h"

namespace waystone {

// A camera's pose. Yaw turns counter-clockwise seen from above, 0 looks east; pitch is positive
// upwards; roll is positive when the camera's top leans to its right. Radians, metres.
// Level, looking east: the camera's x axis (right) is south, its y axis (down) is down.
Eigen::Isometry3d WorldFromCamera(const Eigen::Vector3d& centre, double yaw_rad,
                                  double pitch_rad = 0.0, double roll_rad = 0.0);

struct WalkFrame {
  double time_s = 0.0;
  Eigen::Isometry3d world_from_camera = Eigen::Isometry3d::Identity();
};

struct Walk {
  std::vector<WalkFrame> frames;
};

struct WalkOptions {
  // Height of the camera above the floor, metres, 0.1 to 20 and below the lintels.
  double height_m = 1.5;
  // Largest step from a frame to the next, metres, 0.001 to 1. Longer steps mean fewer frames with
  // less overlap.
  double step_m = 0.05;
  // Largest turn from a frame to the next, radians, 0.001 to 1: in bends the camera slows down.
  double turn_rad = 0.05;
  // Frames a second, 1 to 1000: the time stamps.
  double frame_rate = 15.0;
  // The gaze swings by this angle to the left and right of the trajectory, radians, 0 to 1.5, so
  // that walls are passed at an oblique angle; 0 looks straight ahead.
  double gaze_rad = 0.8;
  // Length of trajectory for a swing to the left, the right and back, metres, 0.5 to 100.
  double gaze_period_m = 7.0;
  // Constant angle between way and gaze, radians, -3.2 to 3.2; pi / 2 looks to the left all the
  // way.
  double gaze_offset_rad = 0.0;
  // How unsteady the hand is: factor on the sway of height (2 cm), pitch (2 degrees) and roll
  // (1 degree), 0 to 5; 0 is a rail.
  double sway = 1.0;
  // Half way the camera stops and turns on the spot by this angle and back, radians, -6.3 to 6.3: a
  // stretch without parallax. 0 is none.
  double turn_on_spot_rad = 0.0;
  // Corners of the trajectory are rounded off over this length, metres, 0.05 to 2.
  double rounding_m = 0.4;
  // Distance kept from walls where the trajectory allows it, metres, 0 to 2.
  double clearance_m = 0.35;
  // Phases of the sway.
  uint64_t seed = 1;

  // Throws MapError(kBadOptions) for a value out of its range.
  void Check() const;
};

// A walk through waypoints in plan coordinates: (column, row), where (0.5, 0.5) is the middle of
// the first cell of the first line. Straight from each to the next, corners rounded. Throws
// MapError(kBadOptions) where the trajectory meets a wall, for fewer than two waypoints, and for
// options out of range. A function of its arguments alone.
Walk WalkThrough(const FloorPlan& plan, const std::vector<Eigen::Vector2d>& waypoints,
                 const WalkOptions& options = {});

// The tour of a plan's stops, '1' to '9' and back to '1': shortest ways between the stops, and at
// each a small loop, so that rooms are seen with parallax and from several sides. Throws
// MapError(kBadOptions) for a plan with fewer than two stops or one that can't be reached.
Walk DemoWalk(const FloorPlan& plan, const WalkOptions& options = {});

// A small office: five rooms on a corridor that runs around in a loop.
FloorPlan DemoPlan();
// Another building, which shares nothing with it; give its World another seed too.
FloorPlan OtherPlan();

}  // namespace waystone
