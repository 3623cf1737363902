// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/appearance_layer.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "builder/build_map.h"
#include "core/base/error.h"
#include "localizer/appearance/appearance.h"
#include "schema/file/map_store.h"
#include "tests/builder/appearance/drive.h"
#include "world/flat.h"

namespace waystone {
namespace {

AppearanceOptions ShortDrive() {
  AppearanceOptions options;
  options.loops.min_gap = 20;
  options.odometry.max_span = 1;  // fast
  return options;
}

BuiltAppearance BuildFromImages(const std::vector<cv::Mat>& images,
                                const AppearanceOptions& options = ShortDrive()) {
  MemorySource source = ImagesSource(images);
  return BuildAppearance({&source}, options);
}

std::vector<cv::Mat> First(int count) {
  const auto& all = TheDrive().panoramas;
  return {all.begin(), all.begin() + count};
}

// A new image: assigning zeros to one would blacken all that share its pixels.
cv::Mat Black(const cv::Size& size) { return {size, CV_8UC1, cv::Scalar(0)}; }

void ExpectRefused(const std::vector<cv::Mat>& images, const std::vector<std::string>& parts) {
  try {
    BuildFromImages(images);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadSource) << error.what();
    for (const std::string& part : parts) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
}

TEST(BuildAppearanceTest, LoopsBringTheWayNearerToTheTruth) {
  const BuiltAppearance result = BuildFromImages(TheDrive().panoramas);
  const Points2 truth = PlacesOf(TheDrive().truth);
  const AppearanceReport& report = result.report;
  EXPECT_EQ(report.panoramas, Drive::kFrames);
  EXPECT_GE(report.loops_supported - report.loops_rejected, 3);
  EXPECT_LT(CompareShapes(truth, PlacesOf(report.poses)).mu, 0.02);
  EXPECT_LE(CompareShapes(truth, PlacesOf(report.poses)).mu,
            CompareShapes(truth, PlacesOf(report.odometry)).mu);
}

TEST(BuildAppearanceTest, SaysWhereTheTrajectoryIsDoubtful) {
  EXPECT_FALSE(BuildFromImages(First(12)).report.IsTrajectoryDoubtful());
  // Through a flat with a panorama a room and one in each doorway: steps as long as the rooms.
  FlatTourOptions tour;
  tour.per_room = 1;
  tour.camera.width_px = 256;
  std::vector<cv::Mat> images;
  for (const FlatPanorama& panorama : PhotographFlat(MakeFlat({}), tour)) {
    images.push_back(panorama.grey);
  }
  const AppearanceReport report = BuildFromImages(images).report;
  EXPECT_EQ(report.steps, static_cast<int>(images.size()) - 1);
  EXPECT_GT(report.uncertain, report.steps / 2);
  EXPECT_TRUE(report.IsTrajectoryDoubtful());
}

TEST(BuildAppearanceTest, IsTheSameForAnyNumberOfThreads) {
  const BuiltAppearance many = BuildFromImages(First(12));
  tbb::task_arena one(1);
  EXPECT_EQ(one.execute([] { return BuildFromImages(First(12)); }).layer, many.layer);
}

TEST(BuildAppearanceTest, LeavesOutWhatIsRedundant) {
  AppearanceOptions options = ShortDrive();
  options.redundancy.max_loss = 0.6;
  const BuiltAppearance result = BuildFromImages(TheDrive().panoramas, options);
  EXPECT_GT(result.layer.dropped, 0);
  EXPECT_EQ(std::ssize(result.layer.nodes) + result.layer.dropped, Drive::kFrames);
  EXPECT_GE(result.layer.edges.size(), result.layer.nodes.size() - 1);
}

TEST(BuildAppearanceTest, TiesSequencesTogetherByTheirLoops) {
  const auto& all = TheDrive().panoramas;
  MemorySource first = ImagesSource({all.begin(), all.begin() + 28}, "first");
  MemorySource second = ImagesSource({all.begin() + 16, all.end()}, "second");
  const BuiltAppearance result = BuildAppearance({&first, &second}, ShortDrive());
  ASSERT_EQ(result.report.poses.size(), 28 + 32);
  Points2 truth = PlacesOf({TheDrive().truth.begin(), TheDrive().truth.begin() + 28});
  for (int i = 16; i < Drive::kFrames; ++i) {
    truth.emplace_back(TheDrive().truth[i].x, TheDrive().truth[i].y);
  }
  EXPECT_LT(CompareShapes(truth, PlacesOf(result.report.poses)).mu, 0.03);
}

TEST(BuildAppearanceTest, SkipsAndNamesABlackPanorama) {
  std::vector<cv::Mat> images = First(6);
  images[2] = Black(images[2].size());
  const BuiltAppearance result = BuildFromImages(images);
  EXPECT_EQ(result.report.skipped, 1);
  EXPECT_EQ(result.sequences[0].skipped, 1);
  EXPECT_EQ(result.layer.nodes.size(), 5);
  ASSERT_EQ(result.report.skipped_names.size(), 1);
  EXPECT_NE(result.report.skipped_names[0].find("image 2: "), std::string::npos);
}

TEST(BuildAppearanceTest, RefusesASequenceOfOne) {
  ExpectRefused(First(1), {"'drive' has 1 usable panorama of 1 frame", "at least two"});
}

TEST(BuildAppearanceTest, RefusesASequenceThatIsAllBlack) {
  ExpectRefused(std::vector<cv::Mat>(3, cv::Mat::zeros(128, 256, CV_8UC1)),
                {"0 usable panoramas of 3 frames", "first: image 0"});
}

TEST(BuildAppearanceTest, StopsWhenToldToInTheMiddleOfAStage) {
  for (const std::string at : {"panoramas", "odometry", "loops", "poses"}) {
    int calls = 0;  // of that stage; the first one is before it begins
    const auto stop = [&](const BuildProgress& now) {
      return now.stage != at || (++calls == 1 && at != "panoramas" && at != "poses");
    };
    try {
      MemorySource source = ImagesSource(at == "loops" ? TheDrive().panoramas : First(6));
      BuildAppearance({&source}, ShortDrive(), stop);
      ADD_FAILURE() << "nothing was thrown in " << at;
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
    }
  }
}

TEST(BuildMapTest, PanoramasBecomeTheAppearanceLayerOfASoundMap) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(ImagesSource(First(8))));
  BuildOptions options;
  options.appearance_calibration.rendered_negatives = 0;
  BuildResult result = BuildMap(sources, options, {});
  ASSERT_TRUE(result.map.appearance.has_value());
  EXPECT_TRUE(result.map.planes.empty());
  ASSERT_TRUE(result.report.appearance.has_value());
  const auto path = std::filesystem::path(testing::TempDir()) / "waystone_appearance.db";
  WriteMap(result.map, path, {.overwrite = true});
  EXPECT_TRUE(CheckMap(path).empty());
  EXPECT_EQ(ReadMap(path).appearance, result.map.appearance);
  std::filesystem::remove(path);
}

// The drive's map as BuildMap makes it, and answers for panoramas from between its own.
const MapData& DriveMap() {
  static const MapData map = [] {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::make_unique<MemorySource>(ImagesSource(TheDrive().panoramas)));
    BuildOptions options;
    options.appearance = ShortDrive();
    options.appearance_calibration.max_nodes = 12;
    options.appearance_calibration.rendered_negatives = 4;
    return BuildMap(sources, options, {}).map;
  }();
  return map;
}

TEST(BuildMapTest, CalibratesTheVerdictOfPanoramas) {
  const AppearanceLayer& layer = *DriveMap().appearance;
  ASSERT_TRUE(layer.verdict && layer.verified_verdict);
  for (const auto& model : {*layer.verdict, *layer.verified_verdict}) {
    EXPECT_GT(model.positives, 0);
    EXPECT_GT(model.negatives, 4);  // the rendered ones and answers without the surroundings
  }
  const int max_kept = NodeFeatureOptions{}.max_kept;
  for (const AppearanceNode& node : layer.nodes) {
    EXPECT_GT(std::ssize(node.features.bearings), max_kept / 2);
    EXPECT_LE(std::ssize(node.features.bearings), max_kept);
  }
}

TEST(BuildMapTest, ACalibratedMapRefusesWhatItDoesntShow) {
  const auto index = MapIndex::Build(DriveMap());
  WorldOptions look;
  look.seed = 99;
  look.texel_m = 0.02;
  const World elsewhere(OtherPlan(), look);
  const Renderer renderer(PanoramaCamera(256));
  for (const double yaw : {0.0, 1.0, 2.0, 3.0}) {
    const cv::Mat foreign =
        renderer.Render(elsewhere, WorldFromCamera({2.5 + yaw, 5, 1.2}, yaw)).grey;
    EXPECT_NE(LocalizePanorama(*index, foreign, {}).verdict, Verdict::kLocalized);
  }
  // Without the nodes around a panorama an answer is refused, or it is right all the same because
  // directions from farther away cross there; far from the truth none is believed.
  int localized = 0;
  const std::vector<AppearanceNode>& nodes = index->map().appearance->nodes;
  for (size_t i = 0; i < Drive::kAround; i += 4) {
    const PanoramaQuery query = DescribeQuery(*index, TheDrive().panoramas[i], {});
    localized += LocatePanorama(*index, query, {}).verdict == Verdict::kLocalized;
    std::vector<bool> left_out;
    for (const Pose2& other : TheDrive().truth) {
      const Pose2& own = TheDrive().truth[i];
      left_out.push_back(std::hypot(other.x - own.x, other.y - own.y) <= 0.6);
    }
    const Answer answer = LocatePanorama(*index, query, {}, left_out);
    const double apart = std::hypot(answer.panorama->pose.x - nodes[i].pose.x,
                                    answer.panorama->pose.y - nodes[i].pose.y);
    // Believed or not, the position says how uncertain it is, in a room of any size.
    EXPECT_LT(apart, 3 * answer.panorama->sigma) << i;
    if (answer.verdict != Verdict::kLocalized) continue;
    EXPECT_LT(apart, 4 * index->appearance().spacing()) << i << " " << answer.probability;
  }
  EXPECT_GE(localized, 5);  // of 10
}

LayerKind MainLayer(const Source& source, const LayerChoice& choice) {
  return ChooseLayers(source, choice).front();
}

TEST(BuildMapTest, LayersAreNamedOrFoundOut) {
  const MemorySource panoramas = ImagesSource(First(1));
  const MemorySource photos = ImagesSource({cv::Mat(48, 64, CV_8UC1)});
  EXPECT_EQ(MainLayer(panoramas, {}), LayerKind::kAppearance);
  EXPECT_EQ(MainLayer(photos, {}), LayerKind::kPlanes);
  EXPECT_EQ(MainLayer(photos, LayerChoiceByNames("appearance")), LayerKind::kAppearance);
  EXPECT_EQ(MainLayer(panoramas, LayerChoiceByNames("planes")), LayerKind::kPlanes);
  EXPECT_EQ(MainLayer(photos, LayerChoiceByNames("planes,appearance")), LayerKind::kPlanes);
  EXPECT_THROW(LayerChoiceByNames("plains"), MapError);
  EXPECT_THROW(LayerChoiceByNames(""), MapError);
}

TEST(BuildMapTest, RefusesALayerThatNoSourceFits) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(ImagesSource(First(3))));
  BuildOptions options;
  options.layers = LayerChoiceByNames("planes,appearance");
  try {
    BuildMap(sources, options, {});
    ADD_FAILURE() << "nothing was thrown";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadSource);
  }
}

}  // namespace
}  // namespace waystone
