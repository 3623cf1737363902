// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/corridors.h"

#include <gtest/gtest.h>

namespace waystone {
namespace {

OrientationFrame FrameAt(int i, double heading_rad, int along_x, int along_y) {
  BuildingRotation rotation;
  Eigen::Matrix3d looking_along_x;  // x ahead, y left, z up
  looking_along_x << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  rotation.building_from_rig = Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()) *
                               Eigen::Quaterniond(looking_along_x);
  return {.id = {i + 1},
          .sequence = {1},
          .frame = i,
          .source = "",
          .time_s = {},
          .reliable = true,
          .rotation = rotation,
          .lines = {along_x, along_y, 5}};
}

// A corridor along x, a turn at frame 100, a corridor along y, a room from frame 200 on in which
// the camera looks another way.
std::vector<OrientationFrame> CorridorWalk() {
  std::vector<OrientationFrame> frames;
  for (int i = 0; i < 260; ++i) {
    const double turn = std::clamp((i - 90) / 20.0, 0.0, 1.0);
    if (i < 100) frames.push_back(FrameAt(i, 1.57 * turn, 40, 10));
    const double heading = 1.57 * turn + (i < 200 ? 0 : 0.7);
    if (i >= 100) frames.push_back(FrameAt(i, heading, i < 200 ? 10 : 30, i < 200 ? 40 : 30));
  }
  return frames;
}

TEST(Corridors, StretchesBetweenTurnsWithOneDominantAxis) {
  const auto frames = CorridorWalk();
  const std::vector<int> turns{100};
  const auto corridors = FindCorridors(frames, turns, {}, {});
  ASSERT_EQ(corridors.size(), 2U);
  EXPECT_EQ(corridors[0].axis, 0);
  EXPECT_EQ(corridors[0].first.value, 1);
  EXPECT_NEAR(static_cast<double>(corridors[0].last.value), 93, 4);
  EXPECT_EQ(corridors[1].axis, 1);
  EXPECT_NEAR(static_cast<double>(corridors[1].first.value), 107, 4);
  EXPECT_NEAR(static_cast<double>(corridors[1].last.value), 200, 5);
}

TEST(Corridors, TheMotionHasToFollowTheirAxis) {
  const auto frames = CorridorWalk();
  const std::vector<int> turns{100};
  const std::vector<SettledMotion> motions{{.first = 0, .last = 90, .quarter_turns = 1},
                                           {.first = 110, .last = 259, .quarter_turns = 3}};
  const auto corridors = FindCorridors(frames, turns, motions, {});
  ASSERT_EQ(corridors.size(), 1U);
  EXPECT_EQ(corridors[0].axis, 1);
}

TEST(Corridors, BridgeAFewFramesWithoutRotationButNotMany) {
  for (const int bad : {8, 20}) {
    auto frames = CorridorWalk();
    for (int i = 40; i < 40 + bad; ++i) {
      frames[i].reliable = false;
      frames[i].rotation.reset();
    }
    const auto corridors = FindCorridors(frames, std::vector<int>{100}, {}, {});
    EXPECT_EQ(corridors.size(), bad == 8 ? 2U : 3U) << bad;
  }
}

TEST(Corridors, NoneWithoutFramesOrInRooms) {
  EXPECT_TRUE(FindCorridors({}, {}, {}, {}).empty());
  std::vector<OrientationFrame> room;
  for (int i = 0; i < 100; ++i) room.push_back(FrameAt(i, 0, 30, 25));
  EXPECT_TRUE(FindCorridors(room, {}, {}, {}).empty());
}

}  // namespace
}  // namespace waystone
