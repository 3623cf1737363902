// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/turns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/geometry/angle.h"

namespace waystone {
namespace {

// A smooth change from 0 to 1 around a frame, over 20 frames as in the paper.
double Bend(int frame, int at) { return std::clamp((frame - at + 10) / 20.0, 0.0, 1.0); }

struct Drive {
  std::vector<TestedJump> jumps;
  std::vector<SettledMotion> motions;
  std::vector<HeadingSample> headings;

  std::vector<DecidedTurn> Decide(const TurnOptions& options) const {
    return DecideTurns(jumps, motions, headings, options);
  }
};

// 200 frames whose camera and motion have given headings; features always match.
Drive Along(const std::function<double(int)>& camera, const std::function<double(int)>& motion,
            const TurnOptions& options) {
  Drive drive;
  JumpWatch watch(options);
  std::vector<HeadingSample> samples;
  for (int i = 0; i < 200; ++i) {
    const double heading = std::remainder(camera(i), 2 * kPi);
    drive.headings.push_back({i, heading});
    if (const auto jump = watch.Next(i, heading)) {
      const double turned = camera(i + 5) - camera(i - 5);
      drive.jumps.push_back({.jump = *jump, .connected = true, .flow_rad = -turned});
    }
    if (i % 5 == 0) samples.push_back({i, std::remainder(motion(i), 2 * kPi)});
  }
  drive.motions = SettledMotions(samples, options);
  return drive;
}

TEST(Turns, ATurnIsOneToTheSideOfTheCameraAndSwitchesTheAxis) {
  const TurnOptions options;
  for (const int side : {1, -1}) {
    const auto heading = [&](int i) { return side * kPi / 2 * Bend(i, 100); };
    const Drive drive = Along(heading, heading, options);
    const auto turns = drive.Decide(options);
    ASSERT_EQ(turns.size(), 1U);
    EXPECT_TRUE(turns[0].confirmed);
    EXPECT_EQ(turns[0].direction, side);
    EXPECT_EQ(turns[0].axis_after, 1);
    EXPECT_NEAR(turns[0].jump.frame, 100, 3);
    EXPECT_NEAR(turns[0].angle_rad, side * kPi / 2, 0.1);
  }
}

// Frames far apart: the axes jump by any amount from one to the next, the heading by 90 degrees.
TEST(Turns, TheAngleIsThatOfTheHeadingWhateverTheStep) {
  const TurnOptions options;
  for (const int side : {1, -1}) {
    for (const double skew_rad : {-0.3, 0.0, 0.3}) {
      const auto heading = [&](int i) { return i < 100 ? skew_rad : side * kPi / 2 - skew_rad; };
      Drive drive = Along(heading, heading, options);
      drive.jumps.at(0).flow_rad = side;  // as if of the other side: the heading knows better
      const auto turns = drive.Decide(options);
      ASSERT_EQ(turns.size(), 1U);
      EXPECT_NEAR(turns[0].angle_rad, side * kPi / 2 - 2 * skew_rad, 1e-9) << skew_rad;
      EXPECT_EQ(turns[0].direction, side);
    }
  }
}

TEST(Turns, TheAxisAfterIsTheCamerasWhereNoMotionIsKnown) {
  const TurnOptions options;
  const auto heading = [](int i) { return kPi / 2 * Bend(i, 100); };
  Drive drive = Along(heading, heading, options);
  drive.motions.clear();
  const auto turns = drive.Decide(options);
  ASSERT_EQ(turns.size(), 1U);
  EXPECT_EQ(turns[0].axis_after, 1);
}

// The paper's frames 1645 to 1713: the camera looks aside and back, the motion goes straight on.
TEST(Turns, ACameraThatTurnsAloneIsToldApart) {
  const TurnOptions options;
  const auto camera = [](int i) { return 1.2 * (Bend(i, 60) - Bend(i, 140)); };
  const Drive drive = Along(
      camera, [](int) { return 0.0; }, options);
  const auto turns = drive.Decide(options);
  ASSERT_EQ(turns.size(), 2U);
  for (const DecidedTurn& turn : turns) {
    EXPECT_FALSE(turn.confirmed);
    EXPECT_EQ(turn.axis_after, 0);
  }
}

TEST(Turns, AJumpBackAndForthWithinATurnIsOneTurn) {
  const TurnOptions options;
  const auto motion = [](int i) { return kPi / 2 * Bend(i, 100); };
  const auto camera = [&](int i) { return motion(i) + 0.8 * std::sin(i) * (i > 95 && i < 105); };
  const Drive drive = Along(camera, motion, options);
  ASSERT_GT(drive.jumps.size(), 1U);
  int confirmed = 0;
  for (const DecidedTurn& turn : drive.Decide(options)) {
    confirmed += turn.confirmed ? 1 : 0;
  }
  EXPECT_EQ(confirmed, 1);
}

TEST(Turns, TheTestDecidesWhereNoMotionIsKnown) {
  const TurnOptions options;
  for (const bool connected : {false, true}) {
    const std::vector<TestedJump> jumps{
        {.jump = {.frame = 50, .quarter_turns = -1}, .connected = connected, .flow_rad = 0}};
    const auto turns = DecideTurns(jumps, {}, {}, options);
    ASSERT_EQ(turns.size(), 1U);
    EXPECT_EQ(turns[0].confirmed, !connected);
    EXPECT_EQ(turns[0].direction, -1);
  }
}

// The paper's test alone, for comparison: a camera that sees all around stays connected.
TEST(Turns, TheTestAloneDecidesWhereMotionsAreLeftOut) {
  TurnOptions options;
  options.use_motions = false;
  const auto along = [](int i) { return kPi / 2 * Bend(i, 100); };
  Drive drive = Along(along, along, options);
  for (const bool connected : {false, true}) {
    for (TestedJump& jump : drive.jumps) jump.connected = connected;
    const auto turns = drive.Decide(options);
    ASSERT_FALSE(turns.empty());
    for (const DecidedTurn& turn : turns) EXPECT_EQ(turn.confirmed, !connected);
  }
}

TEST(Turns, ACameraOnTheDiagonalDoesNotSwitchBackAndForth) {
  JumpWatch watch({});
  int jumps = 0;
  for (int i = 0; i < 100; ++i) jumps += watch.Next(i, kPi / 4 + (i % 2 ? 0.02 : -0.02)) ? 1 : 0;
  EXPECT_EQ(jumps, 0);
}

TEST(Turns, ShortDetoursAndUnknownMotionsDoNotUnsettle) {
  const std::vector<HeadingSample> samples{
      {0, 0.1},  {5, -0.1}, {10, {}},         {15, 0.0},     {20, 0.7}, {25, 0.0},
      {28, 0.1}, {30, 0.0}, {35, kPi / 2},    {40, kPi / 2}, {45, 0.1}, {50, 0.0},
      {55, 0.1}, {60, kPi}, {65, -kPi + 0.1}, {70, kPi}};
  const auto settled = SettledMotions(samples, {});
  ASSERT_EQ(settled.size(), 2U);
  EXPECT_EQ(settled[0].quarter_turns, 0);
  EXPECT_EQ(settled[0].first, 0);
  EXPECT_EQ(settled[0].last, 55) << "two motions don't settle anew";
  EXPECT_EQ(settled[1].quarter_turns, 2);
}

}  // namespace
}  // namespace waystone
