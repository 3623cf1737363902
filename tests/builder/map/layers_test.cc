// SPDX-License-Identifier: Apache-2.0
// Layers that share their sources.
#include "builder/layer_choice.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "schema/file/map_problems.h"
#include "tests/builder/map/stage.h"

namespace waystone {
namespace {

std::vector<std::unique_ptr<Source>> Calibrated(const std::set<int>& broken = {}) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenStage(45, broken, TheStage().renderer.camera()));
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

TEST(Layers, ObserveOneReadingTogether) {
  const MapData& map = BothLayers().map;
  EXPECT_FALSE(map.planes.empty());
  ASSERT_TRUE(map.orientation);
  ASSERT_EQ(map.orientation->frames.size(), 45U);
  for (int i = 0; i < 45; ++i) {
    EXPECT_EQ(map.orientation->frames[i].frame, i);
    EXPECT_EQ(map.orientation->frames[i].sequence.value, 1);
  }
  EXPECT_FALSE(map.orientation->frames[20].rotation);  // unreadable for both
  EXPECT_EQ(BothLayers().report.planes->skipped, 1);
  ASSERT_TRUE(BothLayers().report.orientation);
  EXPECT_EQ(BothLayers().report.orientation->skipped, 1);
  EXPECT_GT(BothLayers().report.orientation->observe_s, 0);
  const std::vector<MapProblem> problems = FindMapProblems(map);
  EXPECT_TRUE(problems.empty()) << problems[0].where << ": " << problems[0].message;
}

TEST(Layers, OrientationIsTheSameAloneAndBesideThePlanes) {
  BuildOptions options = With("orientation");
  options.threads = 1;
  const BuildResult alone = BuildMap(Calibrated({20}), options, {});
  EXPECT_TRUE(alone.map.planes.empty());
  ASSERT_EQ(alone.map.sequences.size(), 1U);
  EXPECT_EQ(alone.map.sequences[0].frames, 45);
  EXPECT_EQ(alone.map.sequences[0].skipped, 1);
  EXPECT_FALSE(alone.report.planes);
  EXPECT_TRUE(alone.map.orientation == BothLayers().map.orientation);
}

TEST(Layers, WithoutACameraThereIsNoOrientationAndAskingForItIsRefused) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenStage(45));
  using enum LayerKind;
  using Kinds = std::vector<LayerKind>;
  EXPECT_EQ(ChooseLayers(*sources[0], {}), Kinds{kPlanes});
  EXPECT_EQ(ChooseLayers(*Calibrated()[0], {}), Kinds{kPlanes});  // one camera only by name
  EXPECT_EQ(ChooseLayers(*Calibrated()[0], LayerChoiceByNames("planes,orientation")),
            (Kinds{kPlanes, kOrientation}));
  EXPECT_EQ(ChooseLayers(*Calibrated()[0], LayerChoiceByNames("planes")), Kinds{kPlanes});
  EXPECT_EQ(ChooseLayers(*sources[0], LayerChoiceByNames("orientation")), Kinds{});
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
