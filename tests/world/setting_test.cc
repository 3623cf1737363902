// SPDX-License-Identifier: Apache-2.0
#include "world/setting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"

namespace waystone {
namespace {

// Of frames that are at least `apart` frames apart.
double ClosestReturn(const std::vector<Pose2>& poses, size_t apart) {
  double closest = 1e9;
  for (size_t i = apart; i < poses.size(); ++i) {
    for (size_t k = 0; k + apart <= i; ++k) {
      closest = std::min(closest, Apart(poses[i], poses[k]));
    }
  }
  return closest;
}

TEST(Setting, ThePapersNumbersOfImagesTenCentimetresApart) {
  for (const auto& [setting, frames] :
       {std::pair(OfficeSetting(), 200), std::pair(LaboratorySetting(), 150)}) {
    const std::vector<Pose2> poses = GroundPoses(setting.walk);
    ASSERT_EQ(std::ssize(poses), frames);
    for (size_t i = 1; i < poses.size(); ++i) {
      // A chord of a bend is a little shorter than its arc.
      EXPECT_NEAR(Apart(poses[i - 1], poses[i]), 0.1, 0.003) << setting.name << ' ' << i;
      const Eigen::Vector3d& centre = setting.walk.frames[i].world_from_camera.translation();
      EXPECT_TRUE(setting.plan.IsFree(centre.head<2>(), 0.2)) << setting.name << ' ' << i;
    }
  }
}

TEST(Setting, TheRobotLooksWhereItGoes) {
  for (const Setting& setting : {OfficeSetting(), LaboratorySetting()}) {
    const std::vector<Pose2> poses = GroundPoses(setting.walk);
    for (size_t i = 1; i < poses.size(); ++i) {
      const double trajectory =
          std::atan2(poses[i].y - poses[i - 1].y, poses[i].x - poses[i - 1].x);
      const double between = WrappedAngle(poses[i].theta_rad - poses[i - 1].theta_rad) / 2;
      // A step on a circle goes along the middle between its two headings.
      EXPECT_NEAR(WrappedAngle(trajectory - poses[i - 1].theta_rad - between), 0, 0.03) << i;
    }
  }
}

TEST(Setting, TheLoopCloses) {
  const std::vector<Pose2> office = GroundPoses(OfficeSetting().walk);
  EXPECT_LT(ClosestReturn(office, 150), 0.05);
  // It follows its beginning for at least two metres.
  int again = 0;
  for (size_t i = 150; i < office.size(); ++i) {
    again += std::any_of(office.begin(), office.begin() + 50,
                         [&](const Pose2& early) { return Apart(early, office[i]) < 0.1; });
  }
  EXPECT_GE(again, 20);
  EXPECT_LT(ClosestReturn(GroundPoses(LaboratorySetting().walk), 100), 0.5);
}

TEST(Setting, OdometryDriftsByItsOptionsAlone) {
  const Setting setting = OfficeSetting();
  const std::vector<Pose2> truth = GroundPoses(setting.walk);
  const std::vector<Pose2> exact =
      WheelOdometry(setting.walk, {.distance_noise = 0, .turn_noise = 0, .turn_bias = 0});
  const std::vector<Pose2> drifting = WheelOdometry(setting.walk);
  EXPECT_EQ(exact.front(), Pose2{});
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT(Apart(truth[0] * exact[i], truth[i]), 1e-9);
  }
  const double drift = Apart(truth[0] * drifting.back(), truth.back());
  EXPECT_GT(drift, 0.3);
  EXPECT_LT(drift, 6);
  EXPECT_EQ(drifting, WheelOdometry(setting.walk));
  EXPECT_NE(drifting.back(), WheelOdometry(setting.walk, {.seed = 2}).back());
}

TEST(Setting, NamesAndOptionsAreChecked) {
  EXPECT_EQ(SettingByName("laboratory").name, "laboratory");
  EXPECT_THROW(SettingByName("attic"), MapError);
  EXPECT_THROW(WheelOdometry({}, {.distance_noise = -1}), MapError);
}

}  // namespace
}  // namespace waystone
