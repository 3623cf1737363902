// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/appearance_index.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

constexpr int kRows = 8;
constexpr int kColumns = 12;

FourierSignature RandomSignature(Random& random) {
  FourierSignature signature;
  signature.magnitudes.resize(kRows, kColumns);
  signature.phases = HalfMatrix::Zero(kRows, kColumns);
  for (Eigen::half& value : signature.magnitudes.reshaped()) {
    value = Eigen::half(static_cast<float>(random.Uniform(0, 2)));
  }
  return signature;
}

AppearanceLayer RandomLayer(int nodes, uint64_t seed) {
  Random random(seed);
  AppearanceLayer layer;
  layer.described.rows = kRows;
  layer.described.k1 = layer.described.k2 = kColumns;
  for (int i = 0; i < nodes; ++i) {
    AppearanceNode node;
    node.id = AppearanceNodeId{i + 1};
    node.pose = {2.0 * i, 0, 0};
    node.signature = RandomSignature(random);
    layer.nodes.push_back(std::move(node));
  }
  return layer;
}

double RootDifference(const FourierSignature& a, const FourierSignature& b) {
  const auto x = a.magnitudes.cast<double>().array().sqrt();
  const auto y = b.magnitudes.cast<double>().array().sqrt();
  return (x - y).abs().sum();
}

TEST(AppearanceIndex, AbandoningFindsWhatTheWholeSearchFinds) {
  const AppearanceIndex index(RandomLayer(300, 1), {.frequencies = kColumns, .stride = 2});
  Random random(2);
  for (int query = 0; query < 20; ++query) {
    const FourierSignature asked = RandomSignature(random);
    const std::vector<NearNode> all = index.Nearest(asked, 300);
    ASSERT_EQ(all.size(), 300U);
    const std::vector<NearNode> few = index.Nearest(asked, 5);
    EXPECT_EQ(few, std::vector<NearNode>(all.begin(), all.begin() + 5));
  }
}

TEST(AppearanceIndex, TheNearestIsThatOfTheUnroundedMagnitudes) {
  const AppearanceLayer layer = RandomLayer(200, 3);
  const AppearanceIndex index(layer, {.frequencies = kColumns});
  Random random(4);
  for (int query = 0; query < 20; ++query) {
    const FourierSignature asked = RandomSignature(random);
    double best = 1e9;
    for (const AppearanceNode& node : layer.nodes) {
      best = std::min(best, RootDifference(node.signature, asked));
    }
    const int found = index.Nearest(asked, 1).front().node;
    // Rounding to bytes moves each difference by less than a level, 1.42 / 255.
    EXPECT_LT(RootDifference(layer.nodes[found].signature, asked), best + kRows * kColumns * 0.006);
  }
}

TEST(AppearanceIndex, ANodeFindsItselfUnlessLeftOut) {
  const AppearanceLayer layer = RandomLayer(50, 5);
  const AppearanceIndex index(layer);
  for (int node = 0; node < 50; ++node) {
    const NearNode itself = index.Nearest(layer.nodes[node].signature, 1).front();
    EXPECT_EQ(itself.node, node);
    EXPECT_EQ(itself.distance, 0);
    std::vector<bool> left_out(50, false);
    left_out[node] = true;
    const NearNode other = index.Nearest(layer.nodes[node].signature, 1, left_out).front();
    EXPECT_NE(other.node, node);
    EXPECT_GT(other.distance, 0.5);
  }
}

TEST(AppearanceIndex, KnowsSpacingAndEmptiness) {
  EXPECT_DOUBLE_EQ(AppearanceIndex(RandomLayer(7, 6)).spacing(), 2.0);
  EXPECT_EQ(AppearanceIndex(RandomLayer(1, 6)).spacing(), 0);
  Random random(7);
  EXPECT_TRUE(AppearanceIndex().Nearest(RandomSignature(random), 3).empty());
  EXPECT_THROW(AppearanceIndex(RandomLayer(2, 6), {.frequencies = 0}), MapError);
}

// Every second node is a floor above the one before.
// Of more nodes than are asked for their nearest one: all parts of the layer count.
TEST(AppearanceIndex, TheSpacingOfManyNodesIsThatOfAllParts) {
  AppearanceLayer layer = RandomLayer(2500, 8);
  double x = 0;
  for (size_t i = 0; i < layer.nodes.size(); ++i) {
    layer.nodes[i].pose = {x += i < 1000 ? 1.0 : 3.0, 0, 0};
  }
  EXPECT_DOUBLE_EQ(AppearanceIndex(layer).spacing(), 3.0) << "of 1,500 of 2,500";
}

TEST(AppearanceIndex, FloorsAboveEachOtherArentNearer) {
  AppearanceLayer layer = RandomLayer(8, 8);
  PoseLayer poses;
  for (int i = 0; i < 8; ++i) {
    AppearanceNode& node = layer.nodes[i];
    node.pose.x = i - i % 2;
    NodePose pose;
    pose.node = node.id;
    pose.rotation = Eigen::AngleAxisd(-EIGEN_PI / 2, Eigen::Vector3d::UnitX());  // z is up
    pose.position = {node.pose.x, node.pose.y, 3.0 * (i % 2)};
    poses.nodes.push_back(pose);
  }
  EXPECT_EQ(AppearanceIndex(layer).spacing(), 0);
  const AppearanceIndex index(layer, {}, &poses);
  EXPECT_DOUBLE_EQ(index.spacing(), 2.0);
  EXPECT_DOUBLE_EQ(index.distances().Between(0, 1), 3.0);
  EXPECT_DOUBLE_EQ(index.distances().Height(0, 1), 3.0);
  poses.nodes.erase(poses.nodes.begin());
  EXPECT_EQ(AppearanceIndex(layer, {}, &poses).distances().Between(0, 1), 0) << "no pose";
}

}  // namespace
}  // namespace waystone
