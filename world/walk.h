// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "core/base/options.h"
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
  double height_m = 1.5;
  double step_m = 0.05;
  double turn_rad = 0.05;
  double frame_rate = 15.0;
  double gaze_rad = 0.8;
  double gaze_period_m = 7.0;
  double gaze_offset_rad = 0.0;
  double sway = 1.0;
  double turn_on_spot_rad = 0.0;
  double rounding_m = 0.4;
  double clearance_m = 0.35;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"height_m", &WalkOptions::height_m, Closed(0.1, 20), "m",
                    "Height of the camera above the floor, below the lintels."},
        OptionField{"step_m", &WalkOptions::step_m, Closed(0.001, 1), "m",
                    "Maximum step from one frame to the next. Longer steps mean fewer frames with "
                    "less overlap."},
        OptionField{"turn_rad", &WalkOptions::turn_rad, Closed(0.001, 1), "rad",
                    "Maximum turn from one frame to the next: the camera slows down in bends."},
        OptionField{"frame_rate", &WalkOptions::frame_rate, Closed(1, 1000), "1/s",
                    "Frames per second, for the time stamps."},
        OptionField{"gaze_rad", &WalkOptions::gaze_rad, Closed(0, 1.5), "rad",
                    "The camera pans by this angle to the left and right of the trajectory, so "
                    "that walls are passed at an oblique angle; 0 looks straight ahead."},
        OptionField{
            "gaze_period_m", &WalkOptions::gaze_period_m, Closed(0.5, 100), "m",
            "Length of trajectory over which the camera pans to the left, to the right and back."},
        OptionField{"gaze_offset_rad", &WalkOptions::gaze_offset_rad, Closed(-3.2, 3.2), "rad",
                    "Constant angle between the trajectory and the viewing direction; pi / 2 looks "
                    "to the left all the time."},
        OptionField{"sway", &WalkOptions::sway, Closed(0, 5), "",
                    "How unsteady the hand is: factor applied to the sway in height (2 cm), pitch "
                    "(2 degrees) and roll (1 degree); 0 moves as on a rail."},
        OptionField{"turn_on_spot_rad", &WalkOptions::turn_on_spot_rad, Closed(-6.3, 6.3), "rad",
                    "Halfway, the camera stops and turns on the spot by this angle and back: a "
                    "stretch without parallax. 0 disables it."},
        OptionField{"rounding_m", &WalkOptions::rounding_m, Closed(0.05, 2), "m",
                    "Corners of the trajectory are rounded off over this length."},
        OptionField{"clearance_m", &WalkOptions::clearance_m, Closed(0, 2), "m",
                    "Distance kept from walls where the trajectory allows it."},
        OptionField{"seed", &WalkOptions::seed, AnyValue(), "",
                    "Random seed of the phases of the sway."});
  }
  // Throws MapError(kBadOptions) for a value out of its range.
  void Check() const;
};

// A walk through waypoints in plan coordinates (column, row), where (0.5, 0.5) is the middle of the
// first cell of the first line. Straight from each to the next, with rounded corners. Throws
// MapError(kBadOptions) where the trajectory meets a wall, for fewer than two waypoints, and for
// options out of range. Pure; thread-safe, as all functions here.
Walk WalkThrough(const FloorPlan& plan, const std::vector<Eigen::Vector2d>& waypoints,
                 const WalkOptions& options = {});

// A tour of a plan's stops, '1' to '9' and back to '1': shortest paths between the stops, and a
// small loop at each, so that rooms are seen with parallax and from several sides. Throws
// MapError(kBadOptions) for a plan with fewer than two stops or one that can't be reached.
Walk DemoWalk(const FloorPlan& plan, const WalkOptions& options = {});

// A small office: five rooms on a corridor that runs around in a loop.
FloorPlan DemoPlan();
// Another building, which has nothing in common with it; give its World another seed too.
FloorPlan OtherPlan();

}  // namespace waystone
