// SPDX-License-Identifier: Apache-2.0
#include "core/localization/graph_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/check.h"
#include "core/base/error.h"

namespace waystone {
namespace {

constexpr int kNodes = 60;  // two corridors of 30 nodes, 0.5 m apart, that look alike ...
constexpr int kHalf = kNodes / 2;
constexpr int kDoor = 20;  // ... but for a door in the second one, from its node 20 on

std::vector<Pose2> Corridors() {
  std::vector<Pose2> poses;
  for (int i = 0; i < kNodes; ++i) poses.push_back({0.5 * (i % kHalf), i < kHalf ? 0.0 : 20.0, 0});
  return poses;
}

// What an image at `truth` says: nodes of either corridor at the same length look the same.
std::vector<NodeEvidence> Aliased(int truth, double heading_rad) {
  std::vector<NodeEvidence> evidence;
  for (int i = 0; i < kNodes; ++i) {
    const int along = i % kHalf - truth % kHalf;
    const bool door = truth >= kHalf + kDoor;
    const bool shows_door = i >= kHalf + kDoor;
    evidence.push_back(
        {-0.5 * along * along - (door != shows_door ? 8.0 : 0.0), heading_rad, 0.05});
  }
  return evidence;
}

double ProbabilityOf(const FilterState& state, int first, int last) {
  double sum = 0;
  for (const Belief& belief : state) {
    if (belief.node >= first && belief.node <= last) sum += belief.probability;
  }
  return sum;
}

TEST(GraphFilter, OneImageOfAnAliasedPlaceIsUnsure) {
  const FilterAnswer answer = UpdateBelief(Corridors(), Aliased(35, 0), {}, {});
  EXPECT_NEAR(ProbabilityOf(answer.state, 0, kHalf - 1), 0.5, 1e-6);
  EXPECT_EQ(answer.state[0].node % kHalf, 35 % kHalf);
}

TEST(GraphFilter, AnAliasedCorridorResolvesAsTheRobotMoves) {
  for (const bool with_odometry : {false, true}) {
    FilterState state;
    double unsure = 0;
    const Pose2 step{0.5, 0, 0};
    for (int node = kHalf + 10; node < kHalf + 25; ++node) {
      const auto odometry = with_odometry ? std::optional(step) : std::nullopt;
      const FilterAnswer answer = UpdateBelief(Corridors(), Aliased(node, 0), state, odometry);
      if (node == kHalf + kDoor - 6) unsure = ProbabilityOf(answer.state, kHalf, kNodes);
      state = answer.state;
    }
    EXPECT_NEAR(unsure, 0.5, 0.01) << "nothing told the corridors apart yet";
    EXPECT_EQ(state[0].node, kHalf + 24);
    EXPECT_GT(ProbabilityOf(state, kHalf, kNodes), 0.99);
  }
}

// What was told apart stays so where images don't tell it any more.
TEST(GraphFilter, TheBeliefIsCarriedAlong) {
  FilterState state = UpdateBelief(Corridors(), Aliased(kHalf + kDoor, 0), {}, {}).state;
  for (int node = kHalf + kDoor - 1; node > kHalf + 2; --node) {
    state = UpdateBelief(Corridors(), Aliased(node, std::numbers::pi), state, {}).state;
    EXPECT_EQ(state[0].node, node);
  }
  EXPECT_GT(ProbabilityOf(state, kHalf, kNodes), 0.9);
}

TEST(GraphFilter, OdometryTellsTheHeadingsApart) {
  // Two nodes at opposite ends; the compass is blind to half a turn.
  const std::vector<Pose2> poses = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  const FilterState at_middle = {{1, 1.0, 0, 0.05}};
  const std::vector<NodeEvidence> same(3, {0, 0, 0.05});
  const FilterAnswer answer =
      UpdateBelief(poses, same, at_middle, Pose2{1, 0, 0}, {.position_sigma = 0.2});
  EXPECT_EQ(answer.state[0].node, 2);
  EXPECT_GT(answer.state[0].probability, 0.99);
  std::vector<NodeEvidence> turned = same;
  turned[2].heading_rad = std::numbers::pi;  // would need a turn that the odometry didn't see
  EXPECT_LT(
      ProbabilityOf(
          UpdateBelief(poses, turned, at_middle, Pose2{1, 0, 0}, {.position_sigma = 0.3}).state, 2,
          2),
      0.7);
}

TEST(GraphFilter, HeadingsAreFused) {
  const FilterAnswer answer = UpdateBelief({{0, 0, 0}}, {{0, 0.2, 0.1}}, {{0, 1.0, 3.0, 0.06}},
                                           Pose2{0, 0, -2.8}, {.turn_sigma_rad = 0.08});
  // Predicted 0.2 with sigma 0.1, seen 0.2 with sigma 0.1.
  EXPECT_NEAR(answer.state[0].heading_rad, 0.2, 1e-9);
  EXPECT_NEAR(answer.state[0].sigma_rad, 0.1 / std::sqrt(2), 1e-9);
  EXPECT_NEAR(answer.state[0].probability, 1, 1e-9);
}

// Whatever weights its mean is rounded with.
TEST(GraphFilter, WithoutOdometryTheImageAloneKnowsTheHeading) {
  const std::vector<Pose2> poses = Corridors();
  for (int i = 1; i < 50; ++i) {
    FilterState previous;
    for (int node = 0; node < 7; ++node) previous.push_back({node, 0.1 + 0.0007 * i, 2.5, 0.05});
    const std::vector<NodeEvidence> seen(kNodes, {0, 0.3, 0.1});
    for (const Belief& belief : UpdateBelief(poses, seen, previous, {}).state) {
      ASSERT_EQ(belief.heading_rad, 0.3) << i;
      ASSERT_EQ(belief.sigma_rad, 0.1) << i;
    }
  }
}

TEST(GraphFilter, AKidnappedRobotIsFoundAgain) {
  FilterState state = {{3, 1.0, 0, 0.05}};
  for (int i = 0; i < 4; ++i) {
    state = UpdateBelief(Corridors(), Aliased(kHalf + 25, 0), state, Pose2{}).state;
  }
  EXPECT_EQ(state[0].node, kHalf + 25);
}

// Evidence that fits every node.
std::vector<NodeEvidence> Anything(int nodes) {
  return std::vector<NodeEvidence>(nodes, {0, 0, 0.05});
}

TEST(GraphFilter, ATrajectoryThatLeavesTheGraphKnowsNoPlace) {
  const FilterState at_the_end = {{kHalf - 1, 1.0, 0, 0.05}};
  const auto here_after = [&](double moved) {
    const Pose2 odometry{moved, 0, 0};
    return ProbabilityOf(UpdateBelief(Corridors(), Anything(kNodes), at_the_end, odometry).state, 0,
                         kHalf - 1);
  };
  EXPECT_GT(here_after(0.4), 0.95);
  EXPECT_NEAR(here_after(10), 0.5, 0.01) << "either corridor";
}

TEST(GraphFilter, FloorsAboveEachOtherAreKeptApart) {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<Pose2> poses;
  std::vector<double> heights;
  for (int i = 0; i < 10; ++i) {
    poses.push_back({0.5 * (i % 5), 0, 0});
    heights.push_back(i < 5 ? 0 : 3);
  }
  const auto below = [&](const std::vector<double>& known) {
    return ProbabilityOf(
        UpdateBelief(poses, Anything(10), {{2, 1.0, 0, 0.05}}, Pose2{0.5, 0, 0}, {}, known).state,
        0, 4);
  };
  EXPECT_GT(below(heights), 0.99);
  EXPECT_NEAR(below(std::vector<double>(10, unknown)), 0.5, 1e-6);
  EXPECT_NEAR(below({}), 0.5, 1e-6);
}

TEST(GraphFilter, ARobotThatStandsStaysAndOneThatCreepsArrives) {
  const GraphFilterOptions options{.position_sigma = 0.5};
  FilterState standing = {{5, 0.7, 0, 0.05}, {kHalf + 5, 0.3, 0, 0.05}};
  for (int i = 0; i < 20; ++i) {
    standing = UpdateBelief(Corridors(), Anything(kNodes), standing, Pose2{}, options).state;
  }
  EXPECT_NEAR(ProbabilityOf(standing, 5, 5), 0.7, 0.02);
  FilterState creeping = {{5, 1.0, 0, 0.05}};
  for (int i = 0; i < 25; ++i) {  // 5 nodes
    creeping =
        UpdateBelief(Corridors(), Anything(kNodes), creeping, Pose2{0.1, 0, 0}, options).state;
  }
  double mean = 0;
  for (const Belief& belief : creeping) {
    if (belief.node < kHalf) mean += belief.probability * belief.node;
  }
  EXPECT_NEAR(mean / ProbabilityOf(creeping, 0, kHalf - 1), 10, 1.5);
}

TEST(GraphFilter, TheStateIsSmallSortedAndSumsToOneAtMost) {
  const FilterAnswer answer = UpdateBelief(Corridors(), Aliased(35, 0), {}, {}, {.max_beliefs = 5});
  ASSERT_EQ(answer.state.size(), 5u);
  double sum = 0;
  for (size_t i = 0; i < answer.state.size(); ++i) {
    sum += answer.state[i].probability;
    const double before = i > 0 ? answer.state[i - 1].probability : 1;
    EXPECT_LE(answer.state[i].probability, before);
  }
  EXPECT_LE(sum, 1);
  EXPECT_EQ(UpdateBelief(Corridors(), Aliased(36, 0), answer.state, {}).state,
            UpdateBelief(Corridors(), Aliased(36, 0), answer.state, {}).state);
}

TEST(GraphFilter, WhatMakesNoSenseIsRefused) {
  const std::vector<Pose2> poses(2);
  const std::vector<NodeEvidence> evidence(2);
  EXPECT_THROW(UpdateBelief({}, {}, {}, {}), CheckFailure);
  EXPECT_THROW(UpdateBelief(poses, {}, {}, {}), CheckFailure);
  EXPECT_THROW(UpdateBelief(poses, evidence, {{2, 0.5, 0, 0.1}}, {}), MapError);
  EXPECT_THROW(UpdateBelief(poses, evidence, {{1, 1.5, 0, 0.1}}, {}), MapError);
  EXPECT_THROW(UpdateBelief(poses, evidence, {}, {}, {.kidnapped = 0}), MapError);
  const double never = -std::numeric_limits<double>::infinity();
  EXPECT_THROW(UpdateBelief(poses, {{never}, {never}}, {}, {}), MapError);
}

}  // namespace
}  // namespace waystone
