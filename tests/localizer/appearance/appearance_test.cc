// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/appearance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/base/error.h"
#include "localizer/appearance/panorama_series.h"
#include "localizer/appearance/photo.h"
#include "localizer/index/node_bearings.h"
#include "localizer/localizer.h"
#include "localizer/session.h"
#include "tests/localizer/made_map.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

constexpr int kPanoramaWidth = 512;
constexpr double kHeight_m = 1.2;

// A panorama on the ground: x ahead is along the heading.
cv::Mat Panorama(const World& world, const Pose2& at) {
  const Renderer renderer(PanoramaCamera(kPanoramaWidth));
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
    const int row = i / 3;
    node.pose = {1.3 + 0.4 * (i % 3), 1.5 + 0.4 * row, WrappedAngle(0.7 * i)};
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

TEST(Appearance, InterpolatesBetweenNodesAndTellsTheHeading) {
  for (const Pose2& truth : kQueries) {
    const Answer answer = LocalizePanorama(Grid(false), Panorama(Rooms(), truth), {});
    ASSERT_TRUE(answer.panorama);
    EXPECT_LT(Apart(answer.panorama->pose, truth), 0.35);
    EXPECT_LT(std::abs(WrappedAngle(answer.panorama->pose.theta_rad - truth.theta_rad)), 0.1);
    EXPECT_EQ(answer.decided_by, DecidedBy::kPanoramaSignature);
    EXPECT_EQ(answer.panorama->candidates.size(), 8U);
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
    EXPECT_LT(answer.heading->sigma_rad, 0.05);
    EXPECT_GT(answer.panorama->candidates.front().inliers, 20);
  }
}

// The least that a map has to know, with and without features.
TEST(Appearance, ANodesOwnPanoramaIsFoundAtTheNode) {
  for (const bool features : {false, true}) {
    const MapIndex& index = Grid(features);
    for (const AppearanceNode& node : index.map().appearance->nodes) {
      const Answer answer = LocalizePanorama(index, Panorama(Rooms(), node.pose), {});
      EXPECT_EQ(answer.verdict, Verdict::kLocalized) << answer.message;
      EXPECT_EQ(answer.panorama->node.id, node.id) << features;
      EXPECT_LT(Apart(answer.panorama->pose, node.pose), 0.1) << features;
    }
  }
}

// A floor above with the same walls: whether it looks the same.
MapData TwoFloors(bool alike) {
  WorldOptions other = TestOptions();
  other.seed = 99;
  const World above(TwoRooms(), other);
  MapData map = GridMap(true);
  map.poses.emplace().unit = LengthUnit::kMetres;
  std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  const size_t count = nodes.size();
  for (size_t i = 0; i < 2 * count; ++i) {
    if (i >= count) nodes.push_back(nodes[i - count]);
    AppearanceNode& node = nodes[i];
    node.id = AppearanceNodeId{static_cast<int64_t>(i) + 1};
    if (i >= count && !alike) {
      const cv::Mat image = Panorama(above, node.pose);
      node.signature = Signature(image, map.appearance->described);
      node.features = ToNodeFeatures(ExtractPanoramaFeatures(image));
    }
    const double height = kHeight_m + (i < count ? 0 : 3);
    map.poses->nodes.push_back(MakeNodePose(
        node.id, WorldFromCamera({node.pose.x, node.pose.y, height}, node.pose.theta_rad)));
  }
  return map;
}

TEST(Appearance, FloorsAboveEachOtherAreDifferentPlaces) {
  for (const bool alike : {true, false}) {
    const auto index = MapIndex::Build(TwoFloors(alike));
    for (const Pose2& truth : kQueries) {
      const Answer answer = LocalizePanorama(*index, Panorama(Rooms(), truth), {});
      EXPECT_EQ(answer.verdict, alike ? Verdict::kAmbiguous : Verdict::kLocalized)
          << answer.message;
      ASSERT_TRUE(answer.panorama->runner_up);
      EXPECT_GT(answer.panorama->runner_up->node.id.value, 9);
    }
  }
}

// The warping search takes rows for elevations: with the wrong ones its headings are off.
TEST(Appearance, HeadingsAreRefinedWithTheLayersBand) {
  MapData map = GridMap(false);
  map.appearance->described.band = {0.2, -1.2};
  for (AppearanceNode& node : map.appearance->nodes) {
    node.signature = Signature(Panorama(Rooms(), node.pose), map.appearance->described);
  }
  const auto index = MapIndex::Build(std::move(map));
  PanoramaQueryOptions default_band;
  for (const Pose2& truth : kQueries) {
    const Answer answer = LocalizePanorama(*index, Panorama(Rooms(), truth), default_band);
    ASSERT_TRUE(answer.panorama);
    EXPECT_LT(std::abs(WrappedAngle(answer.panorama->pose.theta_rad - truth.theta_rad)), 0.05);
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
  const Answer black = LocalizePanorama(
      Grid(false), cv::Mat::zeros(kPanoramaWidth / 2, kPanoramaWidth, CV_8UC1), {});
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
  EXPECT_EQ(photo.decided_by, DecidedBy::kPhoto);
}

TEST(Appearance, ASeriesIsAtLeastAsSureAsItsImages) {
  SeriesOptions options;
  SeriesContext context;
  double last = 0;
  for (int i = 0; i < 4; ++i) {
    const Pose2 truth{1.4 + 0.1 * i, 1.9, 0.2};
    const PanoramaQuery query = DescribeQuery(Grid(true), Panorama(Rooms(), truth), options.query);
    const Answer answer = ContinueSeries(Grid(true), query, context, options);
    context = {answer.belief, Pose2{0.1, 0, 0}};
    EXPECT_LT(Apart(answer.panorama->pose, truth), 0.5);
    EXPECT_EQ(answer.decided_by, DecidedBy::kSeries);
    const Answer alone = LocatePanorama(Grid(true), query, options.query);
    EXPECT_GE(answer.probability, alone.probability) << "image " << i;
    last = answer.probability;
  }
  EXPECT_GT(last, 0.9);
}

// In either direction of travel, from the first image on; the way back with odometry too.
TEST(Appearance, ASeriesOfTheNodesOwnPanoramasNamesThem) {
  for (const bool features : {false, true}) {
    const MapIndex& index = Grid(features);
    std::vector<AppearanceNode> walk = index.map().appearance->nodes;
    for (const bool back : {false, true}) {
      SeriesContext context;
      for (size_t i = 0; i < walk.size(); ++i) {
        if (back && i > 0) context.odometry = Inverse(walk[i - 1].pose) * walk[i].pose;
        const PanoramaQuery query = DescribeQuery(index, Panorama(Rooms(), walk[i].pose), {});
        const Answer answer = ContinueSeries(index, query, context);
        context = {answer.belief, std::nullopt, answer.described};
        EXPECT_EQ(answer.verdict, Verdict::kLocalized) << answer.message;
        EXPECT_EQ(answer.panorama->node.id, walk[i].id) << features << back;
        EXPECT_LT(Apart(answer.panorama->pose, walk[i].pose), 0.1) << features << back;
      }
      std::ranges::reverse(walk);
    }
  }
}

// A building with two corridors that are alike, 20 m apart: the western room's panoramas stand for
// both, each with a noise of its own. The second leads on into the eastern room.
const MapIndex& AliasedCorridors() {
  static const auto index = [] {
    const Renderer renderer(PanoramaCamera(kPanoramaWidth / 2));
    MapData map;
    map.info.name = "aliased";
    map.sequences.push_back({SequenceId{1}, "walk", "panorama", 0, 0, {}});
    AppearanceLayer layer;
    const auto add = [&](double x, double shown_y, double y) {
      AppearanceNode node;
      node.id = AppearanceNodeId{std::ssize(layer.nodes) + 1};
      node.sequence = SequenceId{1};
      node.pose = {x, y, 0};
      RenderOptions noisy;
      noisy.noise_sigma = 4;
      noisy.noise_seed = static_cast<uint64_t>(node.id.value);
      const auto pose = WorldFromCamera({x, shown_y, kHeight_m}, 0);
      node.signature = Signature(renderer.Render(Rooms(), pose, noisy).grey, layer.described);
      layer.nodes.push_back(std::move(node));
    };
    for (const double y : {2.0, 22.0}) {
      for (const double x : {0.9, 1.5, 2.1, 2.7}) add(x, 2.0, y);
    }
    for (const double x : {4.5, 5.1, 5.7, 6.3}) add(x, 2.0, 22.0);
    map.appearance = std::move(layer);
    return MapIndex::Build(std::move(map));
  }();
  return *index;
}

PanoramaQuery InCorridor(double x) {
  return DescribeQuery(AliasedCorridors(), Panorama(Rooms(), {x, 2.0, 0}), {});
}

TEST(Appearance, ASeriesTellsCorridorsApartThatAreAlike) {
  const Answer single = LocatePanorama(AliasedCorridors(), InCorridor(1.5), {});
  EXPECT_EQ(single.verdict, Verdict::kAmbiguous) << single.probability;
  SeriesContext context;
  Answer answer;
  std::vector<Verdict> verdicts;
  for (const double x : {1.5, 2.1, 2.7, 4.5, 5.1}) {  // along the corridor, into the eastern room
    answer = ContinueSeries(AliasedCorridors(), InCorridor(x), context);
    context.previous = answer.belief;
    verdicts.push_back(answer.verdict);
  }
  EXPECT_EQ(verdicts.front(), Verdict::kAmbiguous);
  EXPECT_EQ(verdicts.back(), Verdict::kLocalized);
  EXPECT_NEAR(answer.panorama->pose.y, 22, 1);
  // Back into the corridor: what was ambiguous before is known now.
  for (const double x : {2.7, 2.1}) {
    context.odometry = Pose2{x == 2.7 ? -2.4 : -0.6, 0, 0};
    answer = ContinueSeries(AliasedCorridors(), InCorridor(x), context);
    context.previous = answer.belief;
    EXPECT_EQ(answer.verdict, Verdict::kLocalized);
    EXPECT_NEAR(answer.panorama->pose.y, 22, 1);
  }
}

// Ten panoramas of one place are no more than one.
TEST(Appearance, ASeriesOfARobotThatStandsGrowsNoSurer) {
  for (const bool odometry : {true, false}) {
    for (const double turn_rad : {0.0, 0.3}) {
      SeriesContext context;
      double first = 0;
      for (int i = 0; i < 10; ++i) {
        const PanoramaQuery query =
            DescribeQuery(AliasedCorridors(), Panorama(Rooms(), {1.45, 2.0, turn_rad * i}), {});
        const Answer answer = ContinueSeries(AliasedCorridors(), query, context);
        if (i == 0) first = answer.probability;
        EXPECT_EQ(answer.verdict, Verdict::kAmbiguous) << i << " " << answer.probability;
        EXPECT_NEAR(answer.probability, first, 0.1) << i;
        EXPECT_NEAR(WrappedAngle(answer.panorama->pose.theta_rad - turn_rad * i), 0, 0.1);
        context = {answer.belief, odometry ? std::optional(Pose2{0, 0, turn_rad}) : std::nullopt,
                   answer.described};
      }
    }
  }
}

// It was carried, which its wheels don't know.
TEST(Appearance, ASeriesFollowsARobotThatWasCarried) {
  SeriesContext context;
  Answer answer;
  for (const double x : {4.5, 5.1, 5.7, 1.5, 1.5, 1.5}) {
    const Pose2 moved{x == 4.5 || x == 5.1 ? 0.6 : 0.0, 0, 0};  // from here on
    answer = ContinueSeries(AliasedCorridors(), InCorridor(x), context);
    context = {answer.belief, moved, answer.described};
  }
  EXPECT_LT(answer.panorama->pose.x, 3);
}

// Floors above each other whose panoramas are alike but for one place.
TEST(Appearance, ASeriesKeepsToItsFloor) {
  const auto index = MapIndex::Build(TwoFloors(true));
  const PanoramaQuery query = DescribeQuery(*index, Panorama(Rooms(), kQueries[0]), {});
  SeriesContext context;
  context.previous = {{12, 1.0, kQueries[0].theta_rad, 0.05}};  // of the upper floor
  context.odometry = Pose2{0.4, 0, 0};
  const Answer answer = ContinueSeries(*index, query, context);
  EXPECT_EQ(answer.verdict, Verdict::kLocalized) << answer.probability;
  EXPECT_GT(answer.panorama->node.id.value, 9);
}

// A series whose lines contradict the axes of the map.
TEST(Appearance, ARefusedPanoramaLeavesTheBelief) {
  WorldOptions look = TestOptions();
  look.trim = true;
  const World world(TwoRooms(), look);
  MapData map = GridMap(false);
  map.orientation.emplace();
  for (AppearanceNode& node : map.appearance->nodes) {
    node.frame = static_cast<int>(node.id.value);
    node.signature = Signature(Panorama(world, node.pose), map.appearance->described);
    OrientationFrame frame;
    frame.id = OrientationFrameId{node.id.value};
    frame.sequence = node.sequence;
    frame.frame = node.frame;
    frame.reliable = true;
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) *
                                   WorldFromCamera({0, 0, kHeight_m}, node.pose.theta_rad).linear();
    frame.rotation =
        BuildingRotation{Eigen::Quaterniond(turned), 1e-6 * Eigen::Matrix3d::Identity()};
    map.orientation->frames.push_back(frame);
  }
  AppearanceNode alike = map.appearance->nodes[4];  // elsewhere, so that nothing is certain
  alike.id = AppearanceNodeId{10};
  alike.pose.y += 50;
  map.appearance->nodes.push_back(alike);
  const auto index = MapIndex::Build(std::move(map));
  const Pose2 beside{1.72, 1.9, 2.7};  // the fifth node
  const cv::Mat image =
      Renderer(PanoramaCamera(2 * kPanoramaWidth))
          .Render(world, WorldFromCamera({beside.x, beside.y, kHeight_m}, beside.theta_rad))
          .grey;
  LocalizeOptions options;
  options.series.emplace();
  options.series->previous = {{4, 0.97, 2.7, 0.1}};
  const Answer answer = LocalizeImage(*index, image, options);
  ASSERT_EQ(answer.decided_by, DecidedBy::kBuildingAxes)
      << answer.probability << " " << answer.message;
  EXPECT_EQ(answer.verdict, Verdict::kNotInMap);
  EXPECT_EQ(answer.belief, options.series->previous);
}

TEST(Appearance, ABeliefOfAnotherMapIsRefused) {
  SeriesContext context;
  context.previous = {{99, 0.5, 0, 0.1}};
  EXPECT_THROW(ContinueSeries(AliasedCorridors(), InCorridor(1.5), context), MapError);
}

TEST(Appearance, APhotoIsFoundByWhatItSeesOrRefused) {
  const Camera camera = PinholeCamera(480, 360, 1.4);
  const Renderer renderer(camera);
  const auto photo = [&](const World& world, const Pose2& at) {
    return renderer.Render(world, WorldFromCamera({at.x, at.y, kHeight_m}, at.theta_rad)).grey;
  };
  for (const Pose2& truth : kQueries) {
    const Answer answer = LocalizePhoto(Grid(true), photo(Rooms(), truth), camera, {});
    EXPECT_EQ(answer.verdict, Verdict::kLocalized) << answer.message << answer.probability;
    ASSERT_TRUE(answer.panorama && answer.heading);
    EXPECT_LT(Apart(answer.panorama->pose, truth), 0.3);
    EXPECT_LT(std::abs(WrappedAngle(answer.heading->rad - truth.theta_rad)), 0.03);
  }
  WorldOptions other = TestOptions();
  other.seed = 99;
  const World elsewhere(DemoPlan(), other);
  EXPECT_EQ(LocalizePhoto(Grid(true), photo(elsewhere, {3, 3, 0.2}), camera, {}).verdict,
            Verdict::kNotInMap);
  const cv::Mat image = photo(Rooms(), kQueries[0]);
  EXPECT_NE(LocalizePhoto(Grid(true), image, {}, {}).message.find("field of view"),
            std::string::npos);
  EXPECT_NE(LocalizePhoto(Grid(false), image, camera, {}).message.find("--node-features"),
            std::string::npos);
  const Camera small = PinholeCamera(100, 80, 1);
  EXPECT_NE(LocalizePhoto(Grid(true), image, small, {}).message.find("unscaled"),
            std::string::npos);
}

// A second room like the first, whose nodes were mapped with other headings.
TEST(Appearance, APhotoOfRoomsThatAreAlikeIsAmbiguous) {
  MapData map = GridMap(true);
  std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  for (int i = 0; i < 9; ++i) {
    AppearanceNode alike = nodes[i];
    alike.id = AppearanceNodeId{10 + i};
    alike.pose.y += 50;
    alike.pose.theta_rad = WrappedAngle(alike.pose.theta_rad + 1);
    nodes.push_back(alike);
  }
  const auto index = MapIndex::Build(std::move(map));
  const Camera camera = PinholeCamera(480, 360, 1.4);
  const Renderer renderer(camera);
  for (const Pose2& truth : kQueries) {
    const cv::Mat photo =
        renderer.Render(Rooms(), WorldFromCamera({truth.x, truth.y, kHeight_m}, truth.theta_rad))
            .grey;
    const Answer answer = LocalizePhoto(*index, photo, camera, {});
    EXPECT_EQ(answer.verdict, Verdict::kAmbiguous) << answer.probability;
    ASSERT_TRUE(answer.panorama && answer.panorama->runner_up);
  }
}

TEST(Appearance, WitnessesOfAPhotoAreOfOnePlace) {
  MapData map = GridMap(true);
  std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  nodes = {nodes[0], nodes[4], nodes[4]};
  nodes[2].id = AppearanceNodeId{10};
  nodes[2].pose.y += 50;
  const auto index = MapIndex::Build(std::move(map));
  const Camera camera = PinholeCamera(480, 360, 1.4);
  const Renderer renderer(camera);
  const cv::Mat photo = renderer.Render(Rooms(), WorldFromCamera({1.9, 1.7, kHeight_m}, -2.5)).grey;
  const Answer answer =
      LocalizePhoto(*index, photo, camera, {}, {}, std::vector<bool>{true, false, false});
  EXPECT_EQ(answer.decided_by, DecidedBy::kPhoto);
  EXPECT_EQ(answer.verdict, Verdict::kNotInMap);
}

// A map of panoramas of a mirror and of photos of its images' shape.
MapData MirrorAndPhotos() {
  MapData map = MadeMap();
  map.appearance = GridMap(false).appearance;
  map.appearance->mirror.emplace();
  map.appearance->mirror->width = 640;
  map.appearance->mirror->height = 480;
  map.appearance->mirror->columns = kPanoramaWidth;
  map.appearance->mirror->band = {0.6, -0.6};
  return map;
}

TEST(Appearance, APhotoOfTheMirrorsShapeIsAskedOfThePlanes) {
  for (const bool ring : {false, true}) {
    MapData map = MirrorAndPhotos();
    if (ring) map.appearance->mirror->ring = MirrorRing{{320, 240}, 60, 220};
    const auto index = MapIndex::Build(std::move(map));
    cv::Mat photo(480, 640, CV_8UC1);
    for (int y = 0; y < photo.rows; ++y) photo.row(y).setTo(0.25 * y);
    EXPECT_EQ(LocalizeImage(*index, photo, {}).decided_by, DecidedBy::kFeatures) << ring;
    QueryRequest request;
    request.images = {{"a", "", photo}, {"b", "", photo}};
    const RequestAnswer several = Session(request, {{"map", index}}, {}).Ask();
    EXPECT_FALSE(several.series);
    EXPECT_EQ(several.images[1][0].decided_by, DecidedBy::kFeatures);
    request.odometry = {Pose2{}, Pose2{}};
    EXPECT_TRUE(Session(request, {{"map", index}}, {}).Ask().series) << "a robot's";
  }
}

// The middle of an image stays its middle.
TEST(Appearance, AMirrorsRingIsScaledWithItsImage) {
  const MirrorRing twice = ScaledRing({{319.5, 239.5}, 60, 220}, 2);
  EXPECT_EQ(twice, (MirrorRing{{639.5, 479.5}, 120, 440}));
  EXPECT_EQ(ScaledRing(twice, 0.5), (MirrorRing{{319.5, 239.5}, 60, 220}));
}

TEST(Appearance, AMirrorsImageThatIsTooSmallIsABadImage) {
  MapData map = GridMap(false);
  map.appearance->mirror.emplace();
  map.appearance->mirror->width = 640;
  map.appearance->mirror->height = 480;
  map.appearance->mirror->columns = kPanoramaWidth;
  map.appearance->mirror->ring = MirrorRing{{320, 240}, 200, 208};
  const auto index = MapIndex::Build(std::move(map));
  const Answer answer = LocalizePanorama(*index, cv::Mat(48, 64, CV_8UC1, cv::Scalar(90)), {});
  EXPECT_EQ(answer.verdict, Verdict::kBadImage);
  EXPECT_NE(answer.message.find("too small"), std::string::npos) << answer.message;
}

TEST(Appearance, APhotoPassesOverNodesThatAreLeftOut) {
  LocalizeOptions options;
  options.camera = PinholeCamera(480, 360, 1.4);
  const Renderer renderer(*options.camera);
  const cv::Mat photo = renderer.Render(Rooms(), WorldFromCamera({1.9, 1.7, kHeight_m}, -2.5)).grey;
  std::vector<bool> left_out(9, false);
  left_out[4] = true;
  const Answer answer = LocalizePhoto(Grid(true), photo, options.camera, {}, {}, left_out);
  EXPECT_EQ(answer.verdict, Verdict::kLocalized);
  for (const NodeCandidate& node : answer.panorama->candidates) EXPECT_NE(node.node.id.value, 5);
  left_out.assign(9, true);
  EXPECT_EQ(LocalizePhoto(Grid(true), photo, options.camera, {}, {}, left_out).verdict,
            Verdict::kNotInMap);
}

TEST(Appearance, ADeadlineThatPassedLeavesAPhotoUndecided) {
  LocalizeOptions options;
  options.camera = PinholeCamera(480, 360, 1.4);
  const Renderer renderer(*options.camera);
  const cv::Mat photo = renderer.Render(Rooms(), WorldFromCamera({1.9, 1.7, kHeight_m}, -2.5)).grey;
  const Answer without = LocalizePhoto(Grid(true), photo, options.camera, {}, options.deadline);
  options.deadline = std::chrono::steady_clock::now() + std::chrono::hours(1);
  const Answer early = LocalizeImage(Grid(true), photo, options);
  EXPECT_EQ(early.last_stage, Stage::kDecide);
  EXPECT_EQ(early.verdict, Verdict::kLocalized);
  EXPECT_EQ(early.probability, without.probability);
  options.deadline = std::chrono::steady_clock::now();
  const Answer late = LocalizePhoto(Grid(true), photo, options.camera, {}, options.deadline);
  EXPECT_EQ(late.verdict, Verdict::kUndecided);
  EXPECT_EQ(late.last_stage, Stage::kExtract);
  EXPECT_EQ(late.decided_by, DecidedBy::kDeadline);
  EXPECT_FALSE(late.panorama);
}

TEST(Appearance, NodesThatTheDeadlineKeepsFromBeingVerifiedHaveNoInliers) {
  const PanoramaQuery query = DescribeQuery(Grid(true), Panorama(Rooms(), kQueries[0]), {});
  ASSERT_TRUE(query.features);
  std::vector<ComparedNode> nodes(2);
  nodes[0].node = 0;
  nodes[1].node = 4;
  const auto now = std::chrono::steady_clock::now();
  EXPECT_GT(VerifyByFeatures(Grid(true), *query.features, nodes, {})[0].inliers, 0);
  EXPECT_EQ(VerifyByFeatures(Grid(true), *query.features, nodes, {}, now)[0].inliers, 0);
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
