// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "builder/build_map.h"
#include "core/base/error.h"
#include "localizer/appearance/appearance.h"
#include "schema/file/map_store.h"
#include "tests/builder/appearance/drive.h"
#include "world/flat.h"

namespace waystone {
namespace {

TEST(PanoramaMapTest, PanoramasBecomeTheAppearanceLayerOfASoundMap) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(ImagesSource(FirstPanoramas(8))));
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

TEST(PanoramaMapTest, CalibratesTheVerdictOfPanoramas) {
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

TEST(PanoramaMapTest, ACalibratedMapRefusesWhatItDoesntShow) {
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

TEST(PanoramaMapTest, LayersAreNamedOrFoundOut) {
  const MemorySource panoramas = ImagesSource(FirstPanoramas(1));
  const MemorySource photos = ImagesSource({cv::Mat(48, 64, CV_8UC1)});
  EXPECT_EQ(MainLayer(panoramas, {}), LayerKind::kAppearance);
  EXPECT_EQ(MainLayer(photos, {}), LayerKind::kPlanes);
  EXPECT_EQ(MainLayer(photos, LayerChoiceByNames("appearance")), LayerKind::kAppearance);
  EXPECT_EQ(MainLayer(panoramas, LayerChoiceByNames("planes")), LayerKind::kPlanes);
  EXPECT_EQ(MainLayer(photos, LayerChoiceByNames("planes,appearance")), LayerKind::kPlanes);
  EXPECT_THROW(LayerChoiceByNames("plains"), MapError);
  EXPECT_THROW(LayerChoiceByNames(""), MapError);
}

TEST(PanoramaMapTest, RefusesALayerThatNoSourceFits) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(ImagesSource(FirstPanoramas(3))));
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
