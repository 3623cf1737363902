// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/base/error.h"
#include "localizer/localizer.h"
#include "localizer/panorama_series.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

constexpr int kWidth = 512;
constexpr double kHeight_m = 1.2;

// A panorama on the ground: x ahead is along the heading.
cv::Mat Panorama(const World& world, const Pose2& at) {
  const Renderer renderer(PanoramaCamera(kWidth));
  return renderer.Render(world, WorldFromCamera({at.x, at.y, kHeight_m}, at.theta_rad)).grey;
}

const World& Rooms() {
  static const World world(TwoRooms(), TestOptions());
  return world;
}

// Nodes on a grid through the western room, 0.4 m apart, each with another heading.
MapData GridMap(bool features) {
  MapData map;
  map.info.name = "rooms";
  map.sequences.push_back({SequenceId{1}, "walk", "panorama", 0, 0, {}});
  AppearanceLayer layer;
  for (int i = 0; i < 9; ++i) {
    AppearanceNode node;
    node.id = AppearanceNodeId{i + 1};
    node.sequence = SequenceId{1};
    node.source = std::to_string(i) + ".jpg";
    node.pose = {1.3 + 0.4 * (i % 3), 1.5 + 0.4 * (i / 3), WrappedAngle(0.7 * i)};
    const cv::Mat image = Panorama(Rooms(), node.pose);
    node.signature = Signature(image, layer.described);
    if (features) node.features = ToNodeFeatures(ExtractPanoramaFeatures(image));
    layer.nodes.push_back(std::move(node));
  }
  map.appearance = std::move(layer);
  return map;
}

const MapIndex& Grid(bool features) {
  static const auto plain = MapIndex::Build(GridMap(false));
  static const auto rich = MapIndex::Build(GridMap(true));
  return features ? *rich : *plain;
}

const Pose2 kQueries[] = {{1.5, 1.7, 0.4}, {1.9, 1.7, -2.5}, {1.75, 2.1, 3.0}};

double Apart(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

TEST(Appearance, InterpolatesBetweenNodesAndTellsTheHeading) {
  for (const Pose2& truth : kQueries) {
    const Answer answer = LocalizePanorama(Grid(false), Panorama(Rooms(), truth), {});
    ASSERT_TRUE(answer.panorama);
    EXPECT_LT(Apart(answer.panorama->pose, truth), 0.35);
    EXPECT_LT(std::abs(WrappedAngle(answer.panorama->pose.theta_rad - truth.theta_rad)), 0.1);
    EXPECT_EQ(answer.decided_by, "panorama_signature");
    EXPECT_EQ(answer.nodes.size(), 8U);
  }
}

TEST(Appearance, FeaturesIntersectDirections) {
  for (const Pose2& truth : kQueries) {
    const Answer answer = LocalizePanorama(Grid(true), Panorama(Rooms(), truth), {});
    ASSERT_TRUE(answer.panorama);
    EXPECT_EQ(answer.verdict, Verdict::kLocalized);
    EXPECT_LT(Apart(answer.panorama->pose, truth), 0.15);
    EXPECT_LT(std::abs(WrappedAngle(answer.panorama->pose.theta_rad - truth.theta_rad)), 0.02);
    ASSERT_TRUE(answer.heading);
    EXPECT_LT(answer.heading->deviation_rad, 0.05);
    EXPECT_GT(answer.nodes.front().inliers, 20);
  }
}

TEST(Appearance, AnotherBuildingIsRefusedByFeatures) {
  WorldOptions other = TestOptions();
  other.seed = 99;
  const World elsewhere(DemoPlan(), other);
  const Answer answer = LocalizePanorama(Grid(true), Panorama(elsewhere, {3, 3, 0.2}), {});
  EXPECT_EQ(answer.verdict, Verdict::kNotInMap);
  EXPECT_FALSE(answer.heading);
  EXPECT_FALSE(answer.message.empty());
}

TEST(Appearance, ABadPanoramaIsAnAnswer) {
  const Answer black =
      LocalizePanorama(Grid(false), cv::Mat::zeros(kWidth / 2, kWidth, CV_8UC1), {});
  EXPECT_EQ(black.verdict, Verdict::kBadImage);
  EXPECT_FALSE(black.message.empty());
}

TEST(Appearance, NothingLeftIsNotInMap) {
  const PanoramaQuery query =
      DescribeQuery(Grid(false), Panorama(Rooms(), kQueries[0]), PanoramaQueryOptions{});
  const Answer answer = LocatePanorama(Grid(false), query, {}, std::vector<bool>(9, true));
  EXPECT_EQ(answer.verdict, Verdict::kNotInMap);
  EXPECT_FALSE(answer.panorama);
}

TEST(Appearance, LocalizeAsksTheLayerThatFits) {
  std::vector<uint8_t> bytes;
  cv::imencode(".png", Panorama(Rooms(), kQueries[0]), bytes);
  EXPECT_TRUE(Localize(Grid(false), bytes, "q.png", {}).panorama);
  cv::imencode(".png", cv::Mat(480, 640, CV_8UC1, cv::Scalar(90)), bytes);
  const Answer photo = Localize(Grid(false), bytes, "photo.png", {});
  EXPECT_EQ(photo.verdict, Verdict::kNotInMap);
  EXPECT_EQ(photo.decided_by, "panorama_shape");
}

TEST(Appearance, ASeriesIsAtLeastAsSureAsItsImages) {
  SeriesOptions options;
  FilterState state;
  double last = 0;
  for (int i = 0; i < 4; ++i) {
    const Pose2 truth{1.4 + 0.1 * i, 1.9, 0.2};
    const PanoramaQuery query = DescribeQuery(Grid(true), Panorama(Rooms(), truth), options.query);
    const SeriesStep step = ContinueSeries(Grid(true), query, state, Pose2{0.1, 0, 0}, options);
    state = step.state;
    EXPECT_LT(Apart(step.answer.panorama->pose, truth), 0.5);
    EXPECT_EQ(step.answer.decided_by, "series");
    last = step.answer.probability;
  }
  EXPECT_GT(last, 0.9);
}

TEST(Appearance, RefusesOptionsOutOfRange) {
  PanoramaQueryOptions options;
  options.candidates = 0;
  EXPECT_THROW(options.Check(), MapError);
  SeriesOptions series;
  series.max_log_odds = 0;
  EXPECT_THROW(series.Check(), MapError);
}

TEST(Appearance, AMapWithASignatureOfAnotherShapeIsDamaged) {
  MapData map = GridMap(false);
  map.appearance->nodes[3].signature.magnitudes.resize(2, 2);
  EXPECT_THROW(MapIndex::Build(std::move(map)), MapError);
}

}  // namespace
}  // namespace waystone
