// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "builder/joining/align_layers.h"
#include "builder/joining/append_map.h"
#include "builder/joining/joinable.h"
#include "builder/joining/merge_maps.h"
#include "builder/joining/remove_keyframes.h"
#include "core/base/error.h"
#include "localizer/appearance/appearance.h"
#include "schema/file/map_problems.h"
#include "schema/sessions.h"
#include "tests/builder/joining/driven_maps.h"
#include "tests/builder/joining/walked_maps.h"

namespace waystone {
namespace {

const JoinResult& JoinedPanoramas() {
  static const JoinResult joined =
      MergeMaps({MorningPanoramas(), EveningPanoramas()}, "joined", PanoramaOptionsOf("joined"));
  return joined;
}

// A room of another building.
const MapData& Elsewhere() {
  static const MapData map = [] {
    const World world(OtherPlan(), WorldOptions{.seed = 99, .texture_richness = 0.5});
    const Renderer renderer(PanoramaCamera(256));
    std::vector<cv::Mat> panoramas;
    for (int i = 0; i < 12; ++i) {
      panoramas.push_back(
          renderer.Render(world, WorldFromCamera({2.5 + 0.15 * i, 5, 1.2}, 0.1 * i)).grey);
    }
    return MapOfPanoramas(panoramas, PanoramaOptionsOf("elsewhere"));
  }();
  return map;
}

std::string Refusal(const std::function<void()>& run) {
  try {
    run();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadRequest);
    return error.what();
  }
  return "";
}

TEST(JoinPanoramas, TiesSessionsOfOnePlaceTogether) {
  const MapData& map = JoinedPanoramas().map;
  ASSERT_TRUE(map.appearance);
  EXPECT_EQ(map.appearance->nodes.size(), MorningPanoramas().appearance->nodes.size() +
                                              EveningPanoramas().appearance->nodes.size());
  EXPECT_GT(JoinedPanoramas().report.panoramas_recognised, 10);
  EXPECT_GT(JoinedPanoramas().report.loops, 10);
  EXPECT_EQ(FindParts(map).size(), 1u);
  EXPECT_TRUE(map.appearance->verdict && map.appearance->verified_verdict);
  EXPECT_EQ(WrittenAndRead(map).appearance, map.appearance);
}

// Both layers lie as the drive went: panoramas that follow each other alternate between them.
TEST(JoinPanoramas, PutsBothWhereTheyWereTaken) {
  Points2 places;
  Points2 truth;
  for (const AppearanceNode& node : JoinedPanoramas().map.appearance->nodes) {
    const int first = node.sequence == SequenceId{1} ? 1 : 0;  // "evening" comes first
    const Pose2& taken = TheDrive().truth[2 * node.frame + first];
    places.emplace_back(node.pose.x, node.pose.y);
    truth.emplace_back(taken.x, taken.y);
  }
  EXPECT_EQ(JoinedPanoramas().map.sequences.front().name, "evening");
  EXPECT_LT(CompareShapes(truth, places).mu, 0.1);
}

TEST(JoinPanoramas, AnswersAsTheMapOfTheWholeDoes) {
  const auto whole =
      MapIndex::Build(MapOfPanoramas(TheDrive().panoramas, PanoramaOptionsOf("whole")));
  const auto joined = MapIndex::Build(JoinedPanoramas().map);
  int same = 0;
  int localized = 0;
  for (const cv::Mat& panorama : TheDrive().panoramas) {
    const Verdict verdict = LocalizePanorama(*joined, panorama, {}).verdict;
    same += verdict == LocalizePanorama(*whole, panorama, {}).verdict;
    localized += verdict == Verdict::kLocalized;
  }
  EXPECT_GE(same, std::ceil(0.98 * Drive::kFrames));
  EXPECT_GE(localized, Drive::kFrames - 2);
}

TEST(JoinPanoramas, TheOrderOfMapsDoesNotMatter) {
  EXPECT_EQ(
      MergeMaps({EveningPanoramas(), MorningPanoramas()}, "joined", PanoramaOptionsOf("joined"))
          .map,
      JoinedPanoramas().map);
}

TEST(JoinPanoramas, AsksTheMapsAsConfigured) {
  BuildOptions strict = PanoramaOptionsOf("joined");
  strict.appearance_calibration.query.verify = false;
  strict.appearance_calibration.query.min_probability = 1 - 1e-6;
  const JoinReport report =
      MergeMaps({MorningPanoramas(), EveningPanoramas()}, "joined", strict).report;
  EXPECT_LT(report.panoramas_recognised, JoinedPanoramas().report.panoramas_recognised);
}

TEST(JoinPanoramas, WhatDoesNotMeetStaysApart) {
  const JoinResult joined =
      MergeMaps({MorningPanoramas(), Elsewhere()}, "apart", PanoramaOptionsOf("apart"));
  EXPECT_EQ(joined.report.loops, 0);
  EXPECT_EQ(FindParts(joined.map), (std::vector<std::vector<SequenceId>>{{{1}}, {{2}}}));
  double lowest = 1e9;
  double highest = -1e9;
  for (const AppearanceNode& node : joined.map.appearance->nodes) {
    if (node.sequence == SequenceId{1}) lowest = std::min(lowest, node.pose.y);
    if (node.sequence == SequenceId{2}) highest = std::max(highest, node.pose.y);
  }
  EXPECT_LT(highest, lowest);
  EXPECT_EQ(WrittenAndRead(joined.map).appearance, joined.map.appearance);
}

TEST(JoinPanoramas, AnAddedWalkIsASessionThatCanGoAgain) {
  MapData map = MorningPanoramas();
  map.names = {{"Window", {{NamedKind::kNodes, 2, 4}}, {}}};
  MapData added = EveningPanoramas();
  added.info.version.clear();
  const JoinResult joined = AddToMap(map, added, PanoramaOptionsOf("joined"));
  EXPECT_GT(joined.report.loops, 5);
  ASSERT_EQ(SessionsOf(joined.map).size(), 2u);
  Removal evening;
  for (const AppearanceNode& node : joined.map.appearance->nodes) {
    if (node.sequence == SequenceId{2}) evening.nodes.insert(node.id);
  }
  evening.sequences = {{2}};
  const RemoveResult left = RemoveFromMap(joined.map, evening, PanoramaOptionsOf("left"));
  EXPECT_EQ(left.report.panoramas, static_cast<int>(evening.nodes.size()));
  EXPECT_EQ(left.map.sequences.size(), 1u);
  EXPECT_EQ(left.map.names, map.names);
  ASSERT_EQ(left.map.appearance->nodes.size(), map.appearance->nodes.size());
  for (const AppearanceEdge& edge : left.map.appearance->edges) {
    EXPECT_LE(edge.b, map.appearance->nodes.back().id);
  }
  EXPECT_EQ(WrittenAndRead(left.map).appearance, left.map.appearance);
}

TEST(JoinPanoramas, RefusesPanoramasThatAreDescribedInAnotherWay) {
  BuildOptions options = PanoramaOptionsOf("coarse");
  options.appearance.describe.signature.rows = 16;
  const MapData coarse = MapOfPanoramas(FirstPanoramas(4), options);
  const std::string message = Refusal([&] {
    MergeMaps({MorningPanoramas(), coarse}, "joined", {});
  });
  EXPECT_NE(message.find("32 rows"), std::string::npos) << message;
  EXPECT_NE(message.find("16 rows"), std::string::npos) << message;
}

TEST(OptionsOfMap, DescribePanoramasAsTheMapDoes) {
  MapData map = MorningPanoramas();
  map.appearance->described.rows = 16;
  map.appearance->mirror.emplace().columns = 720;
  map.appearance->mirror->ring = MirrorRing{{320, 240}, 60, 230};
  BuildOptions options = OptionsOfMap(map);
  EXPECT_EQ(options.appearance.describe.signature, map.appearance->described);
  EXPECT_EQ(options.appearance.describe.panorama.columns, 720);
  EXPECT_EQ(options.appearance.describe.panorama.mirror, map.appearance->mirror->ring);
  CheckOptionsFit(map, options);
  options.appearance.describe.signature.rows = 32;
  EXPECT_NE(Refusal([&] { CheckOptionsFit(map, options); }).find("16 rows"), std::string::npos);
  options = OptionsOfMap(map);
  options.features.type = FeatureType::kOrb;
  EXPECT_NE(Refusal([&] { CheckOptionsFit(map, options); }).find("sift"), std::string::npos);
}

TEST(JoinPanoramas, RefusesPanoramasThatAreGivenTwice) {
  MapData again = MorningPanoramas();
  again.info.version = "sha256:again";
  EXPECT_NE(Refusal([&] {
              MergeMaps({MorningPanoramas(), again}, "joined", {});
            }).find("give each walk once"),
            std::string::npos);
}

TEST(RemovePanoramas, RefusesAllAndUnknownOnes) {
  Removal all;
  for (const AppearanceNode& node : MorningPanoramas().appearance->nodes) all.nodes.insert(node.id);
  EXPECT_NE(Refusal([&] {
              RemoveFromMap(MorningPanoramas(), all, {});
            }).find("all " + std::to_string(all.nodes.size()) + " panoramas"),
            std::string::npos);
  try {
    RemoveFromMap(MorningPanoramas(), {{}, {{9999}}}, {});
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotFound);
  }
}

// Of a frame that is tilted, up is the mean of all cameras' tops, which changes with each that
// goes.
TEST(RemovePanoramas, OfATiltedFrameLeavesThoseLeftInIt) {
  MapData map = MorningPanoramas();
  map.appearance->metres_per_unit = 1;
  map.poses.emplace().unit = LengthUnit::kMetres;
  Removal first;
  double pitch = 0.1;
  for (const AppearanceNode& node : map.appearance->nodes) {
    Eigen::Isometry3d pose = WorldFromCamera({node.pose.x, node.pose.y, 1.2}, node.pose.theta_rad);
    pose = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()) * pose *
           Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX());
    map.poses->nodes.push_back(MakeNodePose(node.id, pose));
    pitch *= 0.8;
    if (first.nodes.size() < 4) first.nodes.insert(node.id);
  }
  PutNodesIntoFrame(map);
  ASSERT_TRUE(FindMapProblems(map).empty());
  const MapData left = RemoveFromMap(map, first, PanoramaOptionsOf("left")).map;
  EXPECT_EQ(left.poses->nodes.size(), map.poses->nodes.size() - 4);
  EXPECT_TRUE(FindMapProblems(left).empty());
}

// A bent row of panoramas in two layers, one turned, moved and half as large; a fifth are wrong.
TEST(AlignLayers, FindsWhatMostAgreeWith) {
  const LayerChange truth{2, {3, -1, 0.7}};
  std::vector<PoseInLayers> poses;
  for (int i = 0; i < 20; ++i) {
    const Pose2 from{0.5 * i, 0.02 * i * i, 0.1 * i};
    Pose2 to = truth(from);
    if (i % 5 == 4) to = {-9.0 * i, 4, 2.5};
    poses.push_back({to, from, 0.2});
  }
  const auto change = AlignLayers(poses, false);
  ASSERT_TRUE(change);
  EXPECT_NEAR(change->scale, 2, 0.1);
  EXPECT_NEAR(change->to_from.theta_rad, 0.7, 1e-6);
  EXPECT_NEAR(change->to_from.x, 3, 0.5);
  EXPECT_FALSE(AlignLayers({poses.begin(), poses.begin() + 2}, false));
  for (size_t i = 0; i < poses.size(); ++i) {  // now all disagree
    poses[i].in_to = {std::pow(2.0, static_cast<double>(i)), -20.0 * static_cast<double>(i),
                      3.0 * static_cast<double>(i)};
  }
  EXPECT_FALSE(AlignLayers(poses, true));
}

}  // namespace
}  // namespace waystone
