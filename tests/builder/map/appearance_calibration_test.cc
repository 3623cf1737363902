// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/appearance_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "builder/calibration/own_images.h"
#include "localizer/index/node_bearings.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

constexpr int kNodes = 36;

// Panoramas through the corridor, twice, with their true poses.
MapData WalkMap() {
  static const MapData walk = [] {
    const World world(DemoPlan(), TestOptions());
    const Renderer renderer(PanoramaCamera(512));
    MapData map;
    map.info.name = "walk";
    map.sequences.push_back({SequenceId{1}, "walk", "panorama", 0, 0, {}});
    AppearanceLayer layer;
    for (int i = 0; i < kNodes; ++i) {
      AppearanceNode node;
      node.id = AppearanceNodeId{i + 1};
      node.sequence = SequenceId{1};
      node.frame = i;
      node.source = std::to_string(i) + ".jpg";
      node.pose = {2.0 + 0.3 * (i % 18), i < 18 ? 8.1 : 7.5, WrappedAngle(0.3 * i)};
      const cv::Mat image =
          renderer
              .Render(world, WorldFromCamera({node.pose.x, node.pose.y, 1.4}, node.pose.theta_rad))
              .grey;
      node.signature = Signature(image, layer.described);
      node.features = ToNodeFeatures(ExtractPanoramaFeatures(image));
      if (i > 0) {
        layer.edges.push_back(
            {AppearanceNodeId{i}, node.id, AppearanceEdgeKind::kConsecutive, 0.1, {}, 0.01});
      }
      layer.nodes.push_back(std::move(node));
    }
    map.appearance = std::move(layer);
    return map;
  }();
  return walk;
}

// The nodes themselves as queries: their own signatures and features.
std::vector<AppearanceCalibrationQuery> QueriesOfNodes(const MapIndex& index) {
  std::vector<AppearanceCalibrationQuery> queries;
  for (const AppearanceNode& node : index.map().appearance->nodes) {
    PanoramaQuery query{node.signature,
                        ToBearingFeatures(node.features, index.map().info.feature_type)};
    const int at = static_cast<int>(queries.size());
    queries.push_back({std::move(query), node.pose, at, at});
  }
  return queries;
}

AppearanceVerdict Calibrated(MapData map) {
  const auto index = MapIndex::Build(std::move(map));
  AppearanceCalibrationOptions options;
  options.blank_spacings = {0, 4};
  return CalibrateAppearance(*index, QueriesOfNodes(*index), {}, true, options);
}

TEST(AppearanceCalibration, LearnsWhereThePosesAreTrue) {
  const AppearanceVerdict model = Calibrated(WalkMap());
  EXPECT_GE(model.positives, 20);
  EXPECT_GE(model.negatives, 20);
  const auto weight = [&](const char* name) {
    return std::ranges::find(model.terms, name, &VerdictTerm::name)->weight;
  };
  EXPECT_LE(weight("deviation_spacings"), 0);
  EXPECT_GE(weight("log_inlier_margin"), 0);
  EXPECT_GE(weight("log_inliers"), 0);
  EXPECT_LE(weight("parallax_rad"), 0);
}

// Poses and edges of another walk than the images': images that see each other well are far apart,
// and the model must not learn that this is wrong.
TEST(AppearanceCalibration, ATrajectoryThatContradictsItsImagesTeachesNothing) {
  constexpr int kStride = 7;  // coprime to the number of nodes
  const MapData walk = WalkMap();
  MapData map = walk;
  for (int i = 0; i < kNodes; ++i) {
    map.appearance->nodes[i].signature = walk.appearance->nodes[i * kStride % kNodes].signature;
    map.appearance->nodes[i].features = walk.appearance->nodes[i * kStride % kNodes].features;
  }
  EXPECT_EQ(Calibrated(std::move(map)), DefaultVerdict(true));
}

// The walk on two floors that look alike, `height` apart; the upper one lies a little aside.
MapData TwoFloors(double height) {
  MapData map = WalkMap();
  const std::vector<AppearanceNode> walk = map.appearance->nodes;
  map.sequences.push_back({SequenceId{2}, "above", "panorama", 0, 0, {}});
  map.poses.emplace();
  const auto add_pose = [&](const AppearanceNode& node, double z) {
    map.poses->nodes.push_back(
        MakeNodePose(node.id, WorldFromCamera({node.pose.x, node.pose.y, z}, node.pose.theta_rad)));
  };
  for (const AppearanceNode& node : walk) add_pose(node, 1.4);
  for (AppearanceNode node : walk) {
    node.id.value += kNodes;
    node.sequence = SequenceId{2};
    node.pose.x += 0.1;
    add_pose(node, 1.4 + height);
    map.appearance->nodes.push_back(std::move(node));
  }
  return map;
}

// The answer to a panorama whose neighbours aren't in the map is its twin on the other floor.
TEST(AppearanceCalibration, AnAnswerOnTheFloorAboveIsWrong) {
  EXPECT_NE(Calibrated(TwoFloors(0)), DefaultVerdict(true));
  EXPECT_EQ(Calibrated(TwoFloors(10)), DefaultVerdict(true));
}

TEST(AppearanceCalibration, AMapFindsItsOwnImages) {
  MapData map = WalkMap();
  std::vector<AppearanceSampleFrame> samples;
  for (int i = 0; i < kNodes; ++i) {
    const AppearanceNode& node = map.appearance->nodes[i];
    samples.push_back({node.signature,
                       ToBearingFeatures(node.features, map.info.feature_type),
                       node.pose,
                       i,
                       {},
                       {}});
  }
  samples.push_back(samples[3]);
  samples.back().node = -1;
  const OwnImages own = FindOwnPanoramas(map, samples, {});
  EXPECT_EQ(own.asked, kNodes);
  EXPECT_EQ(own.found, kNodes);
  EXPECT_TRUE(own.AreFound());
  // A model that believes nothing finds none.
  map.appearance->verified_verdict = DefaultVerdict(true);
  map.appearance->verified_verdict->intercept = -1000;
  map.appearance->verdict = DefaultVerdict(false);
  map.appearance->verdict->intercept = -1000;
  EXPECT_EQ(FindOwnPanoramas(map, samples, {}).found, 0);
  EXPECT_FALSE(FindOwnPanoramas(map, samples, {}).AreFound());
}

}  // namespace
}  // namespace waystone
