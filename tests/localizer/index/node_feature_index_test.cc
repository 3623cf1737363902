// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/node_feature_index.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/features/descriptor_codes.h"

namespace waystone {
namespace {

constexpr int kNodes = 40;
constexpr int kPerNode = 60;
constexpr int kStep = 20;  // features that a node doesn't share with the one before it

// Random bytes of about a descriptor's length.
std::vector<uint8_t> MadeDescriptor(uint64_t seed) {
  Random random(seed);
  std::vector<uint8_t> bytes(128);
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.Below(40));
  return bytes;
}

// What is seen from one place: landmarks kStep * node to kStep * node + kPerNode.
Descriptors SeenFrom(int node) {
  Descriptors seen(128);
  for (int i = 0; i < kPerNode; ++i) {
    seen.Append(MadeDescriptor(uint64_t{1} + kStep * node + i).data());
  }
  return seen;
}

AppearanceLayer MadeLayer() {
  AppearanceLayer layer;
  for (int i = 0; i < kNodes; ++i) {
    AppearanceNode& node = layer.nodes.emplace_back();
    if (i == 7) continue;  // one that keeps none
    node.features.bearings.resize(kPerNode);
    node.features.codes = EncodeDescriptors(SeenFrom(i), FeatureType::kSift);
  }
  return layer;
}

InvertedFileOptions InLists() {
  InvertedFileOptions lists = kNodeFeatureLists;
  lists.min_rows = 100;
  return lists;
}

TEST(NodeFeatureIndex, NodesThatSawItComeFirst) {
  for (const InvertedFileOptions& lists : {kNodeFeatureLists, InLists()}) {
    const NodeFeatureIndex index(MadeLayer(), FeatureType::kSift, lists);
    const std::vector<int> nodes = index.MostVoted(SeenFrom(20), 3, 10, 8);
    ASSERT_EQ(nodes.size(), 3U);
    EXPECT_EQ(nodes[0], 20);
    EXPECT_EQ(nodes[1] + nodes[2], 40) << "its neighbours";
    EXPECT_LE(std::abs(nodes[1] - 20), 1);
  }
}

TEST(NodeFeatureIndex, PassesOverNodesThatAreLeftOut) {
  const NodeFeatureIndex index(MadeLayer(), FeatureType::kSift);
  std::vector<bool> left_out(kNodes, false);
  left_out[20] = true;
  for (const int node : index.MostVoted(SeenFrom(20), 5, 10, 8, left_out)) EXPECT_NE(node, 20);
  left_out.assign(kNodes, true);
  EXPECT_TRUE(index.MostVoted(SeenFrom(20), 5, 10, 8, left_out).empty());
}

TEST(NodeFeatureIndex, WithoutFeaturesNobodyHasVotes) {
  AppearanceLayer layer;
  layer.nodes.resize(3);
  const NodeFeatureIndex index(layer, FeatureType::kSift);
  EXPECT_TRUE(index.MostVoted(SeenFrom(0), 5, 10, 8).empty());
  const NodeFeatureIndex other(MadeLayer(), FeatureType::kSift);
  EXPECT_TRUE(other.MostVoted(Descriptors(128), 5, 10, 8).empty());
}

TEST(NodeFeatureIndex, IsTheSameOnAnyNumberOfThreads) {
  const NodeFeatureIndex parallel(MadeLayer(), FeatureType::kSift, InLists());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const NodeFeatureIndex serial(MadeLayer(), FeatureType::kSift, InLists());
  for (const int node : {0, 13, 39}) {
    EXPECT_EQ(parallel.MostVoted(SeenFrom(node), 8, 10, 2),
              serial.MostVoted(SeenFrom(node), 8, 10, 2));
  }
}

TEST(NodeFeatureIndex, RefusesOptionsOutOfRange) {
  InvertedFileOptions lists = kNodeFeatureLists;
  lists.min_rows = 0;
  EXPECT_THROW(NodeFeatureIndex(MadeLayer(), FeatureType::kSift, lists), MapError);
}

}  // namespace
}  // namespace waystone
