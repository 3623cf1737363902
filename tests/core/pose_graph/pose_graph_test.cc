// SPDX-License-Identifier: Apache-2.0
#include "core/pose_graph/pose_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

constexpr int kPoses = 100;

// Once around a circle of 3 m; the first pose lies at the origin.
std::vector<Pose2> Circle() {
  std::vector<Pose2> poses;
  for (int i = 0; i < kPoses; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoses;
    poses.push_back({3 * std::sin(angle), 3 - 3 * std::cos(angle), WrappedAngle(angle)});
  }
  return poses;
}

struct Graph {
  std::vector<Pose2> start;
  std::vector<PoseEdge> edges;
};

// Odometry with noise and a drift of the heading, its lengths multiplied by `unit`.
Graph Drifting(const std::vector<Pose2>& truth, double unit = 1, int scale_group = 0) {
  Random random(5);
  Graph graph;
  graph.start = {truth[0]};
  for (int i = 1; i < kPoses; ++i) {
    Pose2 step = Inverse(truth[i - 1]) * truth[i];
    step.x = unit * (step.x + 0.004 * random.Normal());
    step.y = unit * (step.y + 0.004 * random.Normal());
    step.theta_rad += 0.01 + 0.005 * random.Normal();
    graph.start.push_back(graph.start.back() * step);
    graph.edges.push_back({i - 1, i, step, 0.01, 0.012, false, scale_group});
  }
  return graph;
}

PoseEdge LoopEdge(const std::vector<Pose2>& truth, int a, int b) {
  return {a, b, Inverse(truth[a]) * truth[b], 0.03, 0.02, true, 0};
}

double WorstError(const std::vector<Pose2>& truth, const std::vector<Pose2>& poses) {
  double worst = 0;
  for (int i = 0; i < kPoses; ++i) worst = std::max(worst, Apart(truth[i], poses[i]));
  return worst;
}

TEST(PoseGraph, ALoopWithDriftCloses) {
  const std::vector<Pose2> truth = Circle();
  Graph graph = Drifting(truth);
  EXPECT_GT(WorstError(truth, graph.start), 1.5);
  graph.edges.push_back(LoopEdge(truth, 0, kPoses - 1));
  graph.edges.push_back(LoopEdge(truth, 1, kPoses - 2));
  const PoseGraphResult result = OptimisePoseGraph(graph.start, graph.edges);
  EXPECT_EQ(std::count(result.rejected.begin(), result.rejected.end(), true), 0);
  EXPECT_EQ(result.poses[0], truth[0]);
  EXPECT_LT(Apart(result.poses.back(), truth.back()), 0.05);
  EXPECT_LT(WorstError(truth, result.poses), 0.3);
}

// Edges without errors give the truth from any start nearby.
TEST(PoseGraph, ExactEdgesGiveTheTruth) {
  const std::vector<Pose2> truth = Circle();
  Graph graph = Drifting(truth);
  for (PoseEdge& edge : graph.edges) edge.a_from_b = Inverse(truth[edge.a]) * truth[edge.b];
  graph.edges.push_back(LoopEdge(truth, 3, 90));
  const PoseGraphResult result = OptimisePoseGraph(graph.start, graph.edges);
  EXPECT_LT(WorstError(truth, result.poses), 1e-4);
}

TEST(PoseGraph, AWrongLoopEdgeIsRejected) {
  const std::vector<Pose2> truth = Circle();
  Graph graph = Drifting(truth);
  for (const auto& [a, b] : {std::pair(0, 99), {1, 98}, {2, 97}, {5, 95}}) {
    graph.edges.push_back(LoopEdge(truth, a, b));
  }
  const PoseGraphResult without = OptimisePoseGraph(graph.start, graph.edges);
  // The other side of the circle taken for the same place.
  PoseEdge wrong = LoopEdge(truth, 20, 70);
  wrong.a_from_b = {0.1, 0, 0};
  graph.edges.push_back(wrong);
  const PoseGraphResult with = OptimisePoseGraph(graph.start, graph.edges);
  EXPECT_TRUE(with.rejected.back());
  EXPECT_EQ(std::count(with.rejected.begin(), with.rejected.end(), true), 1);
  EXPECT_LT(WorstError(without.poses, with.poses), 0.01);
}

// Appearance measures lengths in a unit of its own; loops in metres settle it.
TEST(PoseGraph, AnUnknownUnitIsFound) {
  const std::vector<Pose2> truth = Circle();
  Graph graph = Drifting(truth, 1.6, 1);
  for (PoseEdge& edge : graph.edges) edge.position_sigma *= 1.6;
  for (const auto& [a, b] : {std::pair(0, 99), {0, 50}, {25, 75}, {10, 60}}) {
    PoseEdge edge = LoopEdge(truth, a, b);
    edge.loop = false;
    graph.edges.push_back(edge);
  }
  const PoseGraphResult result = OptimisePoseGraph(graph.start, graph.edges);
  ASSERT_EQ(result.scales.size(), 2u);
  EXPECT_EQ(result.scales[0], 1);
  EXPECT_NEAR(result.scales[1] * 1.6, 1, 0.02);
  EXPECT_LT(WorstError(truth, result.poses), 0.3);
}

TEST(PoseGraph, PartsThatNothingJoinsStayInTheirPlaces) {
  const std::vector<Pose2> start = {{0, 0, 0}, {1.1, 0, 0}, {7, 7, 1}, {9, 9, 2}, {4, 4, 0.5}};
  const std::vector<PoseEdge> edges = {{0, 1, {1, 0, 0}}, {2, 3, {1, 0, 0}}};
  const PoseGraphResult result = OptimisePoseGraph(start, edges);
  EXPECT_EQ(result.poses[0], start[0]);
  EXPECT_EQ(result.poses[2], start[2]);
  EXPECT_EQ(result.poses[4], start[4]);
  EXPECT_NEAR(result.poses[1].x, 1, 1e-6);
  EXPECT_LT(Apart(result.poses[3], start[2] * Pose2{1, 0, 0}), 1e-6);
  EXPECT_TRUE(OptimisePoseGraph({}, {}).poses.empty());
}

TEST(PoseGraph, TheSameBytesEachTime) {
  const std::vector<Pose2> truth = Circle();
  Graph graph = Drifting(truth);
  graph.edges.push_back(LoopEdge(truth, 0, 99));
  EXPECT_EQ(OptimisePoseGraph(graph.start, graph.edges).poses,
            OptimisePoseGraph(graph.start, graph.edges).poses);
}

TEST(PoseGraph, WhatMakesNoSenseIsRefused) {
  EXPECT_THROW(OptimisePoseGraph({{}, {}}, {{0, 2, {}}}), CheckFailure);
  EXPECT_THROW(OptimisePoseGraph({{}, {}}, {{1, 1, {}}}), CheckFailure);
  EXPECT_THROW(OptimisePoseGraph({{}, {}}, {{0, 1, {}, 0.0}}), CheckFailure);
  EXPECT_THROW(OptimisePoseGraph({}, {}, {.loop_loss = 0}), MapError);
  EXPECT_THROW(OptimisePoseGraph({}, {}, {.max_iterations = 0}), MapError);
}

TEST(PoseGraph, APoseThatIsHugeEnds) {
  const std::vector<Pose2> truth = Circle();
  Graph graph = Drifting(truth);
  graph.start.back().x = 1e308;
  graph.edges.push_back(LoopEdge(truth, 0, kPoses - 1));
  EXPECT_EQ(OptimisePoseGraph(graph.start, graph.edges).poses.size(), truth.size());
}

}  // namespace
}  // namespace waystone
