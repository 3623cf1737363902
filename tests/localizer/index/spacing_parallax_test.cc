// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/spacing_parallax.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "localizer/index/node_bearings.h"

namespace waystone {
namespace {

constexpr int kBallPoints = 150;

// Nodes 0.5 apart on a line through a ball of points of this radius, each point with a descriptor
// of its own.
AppearanceLayer LineThroughABall(int nodes, double radius) {
  Random random(3);
  constexpr int kBytes = 128;  // of a SIFT descriptor
  std::vector<Eigen::Vector3d> points;
  Descriptors descriptors(kBytes);
  while (std::ssize(points) < kBallPoints) {
    const Eigen::Vector3d point(random.Uniform(-1, 1), random.Uniform(-1, 1),
                                random.Uniform(-1, 1));
    if (point.norm() < 0.7 || point.norm() > 1) continue;
    std::vector<uint8_t> row(kBytes);
    for (uint8_t& byte : row) byte = static_cast<uint8_t>(random.Uniform(0, 90));
    descriptors.Append(row.data());
    points.emplace_back(radius * point);
  }
  AppearanceLayer layer;
  for (int i = 0; i < nodes; ++i) {
    AppearanceNode node;
    node.id = AppearanceNodeId{i + 1};
    node.sequence = SequenceId{1};
    node.pose = {0.5 * i, 0, 0};
    BearingFeatures seen;
    seen.descriptors = descriptors;
    const Eigen::Vector3d camera(0, 0, 0.5 * i);  // z is ahead, which is the layer's x
    for (const Eigen::Vector3d& point : points) seen.rays.push_back((point - camera).normalized());
    node.features = ToNodeFeatures(seen);
    layer.nodes.push_back(std::move(node));
  }
  return layer;
}

// Points r away, seen from a distance d apart at angle a to the motion, differ by d sin(a) / r: on
// a sphere the median of sin(a) is 0.87.
TEST(SpacingParallax, IsTheDistanceOverTheSizeOfTheRoom) {
  const double small = MeasureSpacingParallax(LineThroughABall(4, 5), FeatureType::kSift, 0.5);
  EXPECT_NEAR(small, 0.87 * 0.5 / (0.87 * 5), 0.03);
  const double large = MeasureSpacingParallax(LineThroughABall(4, 20), FeatureType::kSift, 0.5);
  EXPECT_NEAR(large, small / 4, 0.01);
}

TEST(SpacingParallax, IsUnknownWithoutFeaturesOrNeighbours) {
  EXPECT_EQ(MeasureSpacingParallax({}, FeatureType::kSift, 0), 0);
  EXPECT_EQ(MeasureSpacingParallax(LineThroughABall(1, 5), FeatureType::kSift, 0.5), 0);
  AppearanceLayer layer = LineThroughABall(4, 5);
  for (AppearanceNode& node : layer.nodes) node.features = {};
  EXPECT_EQ(MeasureSpacingParallax(layer, FeatureType::kSift, 0.5), 0);
  // Nodes that follow each other in other sequences have no distance that odometry measured.
  AppearanceLayer apart = LineThroughABall(2, 5);
  apart.nodes[1].sequence = SequenceId{2};
  EXPECT_EQ(MeasureSpacingParallax(apart, FeatureType::kSift, 0.5), 0);
  SpacingParallaxOptions options;
  options.pairs = 0;
  EXPECT_THROW(MeasureSpacingParallax(apart, FeatureType::kSift, 0.5, options), MapError);
}

}  // namespace
}  // namespace waystone
