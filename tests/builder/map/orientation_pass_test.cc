// SPDX-License-Identifier: Apache-2.0
// The orientation layer beside the planes.
#include "builder/orientation_pass.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "schema/file/map_problems.h"
#include "tests/builder/map/stage.h"

namespace waystone {
namespace {

std::vector<std::unique_ptr<Source>> Calibrated(std::set<int> broken = {}) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(
      std::make_unique<MemorySource>(45, std::move(broken), TheStage().renderer.camera()));
  return sources;
}

BuildOptions With(const std::string& layers) {
  BuildOptions options;
  options.layers = LayerChoiceByNames(layers);
  options.calibration.rendered_negatives = 0;
  return options;
}

// Planes and directions of the stage, made once.
const BuildResult& BothLayers() {
  static const BuildResult result = BuildMap(Calibrated({20}), With("planes,orientation"), {});
  return result;
}

TEST(OrientationPass, GivesTheLayerBesideThePlanesFromOneReading) {
  const MapData& map = BothLayers().map;
  EXPECT_FALSE(map.planes.empty());
  ASSERT_TRUE(map.orientation);
  ASSERT_EQ(map.orientation->frames.size(), 45U);
  for (int i = 0; i < 45; ++i) {
    EXPECT_EQ(map.orientation->frames[i].frame, i);
    EXPECT_EQ(map.orientation->frames[i].sequence.value, 1);
  }
  EXPECT_FALSE(map.orientation->frames[20].rotation);  // unreadable for both
  EXPECT_EQ(BothLayers().report.skipped, 1);
  ASSERT_TRUE(BothLayers().report.orientation);
  EXPECT_EQ(BothLayers().report.orientation->unreadable, 1);
  EXPECT_GT(BothLayers().report.orientation->look_s, 0);
  const std::vector<MapProblem> problems = FindMapProblems(map);
  EXPECT_TRUE(problems.empty()) << problems[0].where << ": " << problems[0].message;
}

TEST(OrientationPass, ReadsAloneWhatItSawOnTheWay) {
  BuildOptions options = With("orientation");
  options.threads = 1;
  const BuildResult alone = BuildMap(Calibrated({20}), options, {});
  EXPECT_TRUE(alone.map.planes.empty());
  ASSERT_EQ(alone.map.sequences.size(), 1U);
  EXPECT_EQ(alone.map.sequences[0].frames, 45);
  EXPECT_TRUE(alone.map.orientation == BothLayers().map.orientation);
}

TEST(OrientationPass, WithoutACameraThereIsNoLayerAndAskingForItIsRefused) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(45, std::set<int>{}));
  EXPECT_FALSE(GivesOrientation(*sources[0], {}));
  EXPECT_FALSE(GivesOrientation(*Calibrated()[0], {}));  // one camera is asked only by name
  EXPECT_TRUE(GivesOrientation(*Calibrated()[0], LayerChoiceByNames("planes,orientation")));
  EXPECT_FALSE(GivesOrientation(*Calibrated()[0], LayerChoiceByNames("planes")));
  EXPECT_FALSE(LayerOf(*sources[0], LayerChoiceByNames("orientation")));
  for (const char* layers : {"orientation", "planes,orientation"}) {
    try {
      BuildMap(sources, With(layers), {});
      FAIL() << layers;
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadCamera);
      EXPECT_NE(std::string(error.what()).find("use --camera"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace waystone
