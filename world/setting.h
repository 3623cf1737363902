// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/options.h"
#include "core/geometry/pose2.h"
#include "world/floor_plan.h"
#include "world/walk.h"
#include "world/world.h"

// The two settings in which Fernandez et al. (2011) drove their robot (sec. V, figs. 4 and 5), as
// synthetic buildings, and what the robot's wheels would report of such a drive. All functions are
// deterministic; thread-safe.
namespace waystone {

// A drive through a synthetic building: a panorama every 10 cm, with a level camera at a robot's
// height, looking along the motion.
struct Setting {
  std::string name;
  FloorPlan plan;
  WorldOptions look;
  Walk walk;
};

// 200 panoramas around a loop through three rooms, which closes after about 17 m and then follows
// its beginning for another 3 m.
Setting OfficeSetting();
// 150 panoramas through one large room with pillars and cupboards, back to near the beginning. The
// paper's robot took a new image when it differed enough from the last; here they are as far apart
// as in the office.
Setting LaboratorySetting();

// The setting with a name, "office" or "laboratory". Throws MapError(kBadOptions) for another name.
Setting SettingByName(std::string_view name);

struct OdometryOptions {
  double distance_noise = 0.05;
  double turn_noise = 0.05;
  double turn_bias = 0.05;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"distance_noise", &OdometryOptions::distance_noise, Closed(0, 0.5), "",
                    "Standard deviation of a wheel's slip, as a share of each step."},
        OptionField{
            "turn_noise", &OdometryOptions::turn_noise, Closed(0, 1), "",
            "Standard deviation of the error of the heading, rad per square root of a metre."},
        OptionField{"turn_bias", &OdometryOptions::turn_bias, Closed(-1, 1), "rad/m",
                    "Constant error of the heading, as caused by wheels of unequal size."},
        OptionField{"seed", &OdometryOptions::seed, AnyValue(), "", "Random seed of all noise."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// What wheels would report of a walk: a pose per image in the frame of the first one, whose x is
// along the first gaze; errors accumulate.
std::vector<Pose2> WheelOdometry(const Walk& walk, const OdometryOptions& options = {});

// The true poses on the ground, world frame: a robot's x is along the gaze.
std::vector<Pose2> GroundPoses(const Walk& walk);

}  // namespace waystone
