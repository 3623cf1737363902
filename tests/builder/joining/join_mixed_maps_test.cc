// SPDX-License-Identifier: Apache-2.0
// Maps that have photos and panoramas: each layer is joined with the same layer of the others.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "builder/joining/merge_maps.h"
#include "builder/joining/remove_keyframes.h"
#include "localizer/appearance/appearance.h"
#include "schema/sessions.h"
#include "tests/builder/joining/driven_maps.h"
#include "tests/builder/joining/walked_maps.h"

namespace waystone {
namespace {

MapData Mixed(const MapData& photos, const MapData& panoramas, const std::string& name) {
  return WrittenAndRead(MergeMaps({photos, panoramas}, name, PanoramaOptionsOf(name)).map);
}

const MapData& Morning() {
  static const MapData map = Mixed(FirstHalf(), MorningPanoramas(), "morning");
  return map;
}
const MapData& Evening() {
  static const MapData map = Mixed(SecondHalf(), EveningPanoramas(), "evening");
  return map;
}
const JoinResult& Both() {
  static const JoinResult joined =
      MergeMaps({Morning(), Evening()}, "both", PanoramaOptionsOf("both"));
  return joined;
}

// Of frames of the stage and panoramas of the drive, in this order.
std::vector<Verdict> VerdictsOf(const MapData& map) {
  const auto index = MapIndex::Build(map);
  std::vector<Verdict> verdicts;
  for (const Features& photo : FeaturesOfFrames()) {
    verdicts.push_back(LocalizeFeatures(*index, photo, {}).verdict);
  }
  for (const cv::Mat& panorama : TheDrive().panoramas) {
    verdicts.push_back(LocalizePanorama(*index, panorama, {}).verdict);
  }
  return verdicts;
}

TEST(MixedMaps, HaveTheLayersThatTheyWereMadeOf) {
  const MapData& map = Morning();
  EXPECT_EQ(map.keyframes.size(), FirstHalf().keyframes.size());
  EXPECT_EQ(map.planes.size(), FirstHalf().planes.size());
  EXPECT_EQ(map.verdict, FirstHalf().verdict);
  ASSERT_TRUE(map.appearance);
  EXPECT_EQ(map.appearance->nodes.size(), MorningPanoramas().appearance->nodes.size());
  EXPECT_EQ(map.appearance->verdict, MorningPanoramas().appearance->verdict);
  EXPECT_EQ(map.appearance->verified_verdict, MorningPanoramas().appearance->verified_verdict);
  EXPECT_EQ(FindParts(map).size(), 2u);
}

TEST(MixedMaps, AreJoinedLayerByLayer) {
  const JoinReport& report = Both().report;
  EXPECT_GT(report.keyframes_recognised, 0);
  EXPECT_GT(report.planes_fused, 0);
  EXPECT_GT(report.panoramas_recognised, 10);
  EXPECT_GT(report.loops, 10);
  EXPECT_EQ(report.sessions, 4);
  EXPECT_EQ(FindParts(Both().map).size(), 2u);
  EXPECT_EQ(WrittenAndRead(Both().map).appearance, Both().map.appearance);
}

TEST(MixedMaps, AnswerAsTheJoinedLayersDo) {
  const std::vector<Verdict> both = VerdictsOf(Both().map);
  const auto photos = MapIndex::Build(MergeMaps({FirstHalf(), SecondHalf()}, "photos", {}).map);
  const auto panoramas = MapIndex::Build(
      MergeMaps({MorningPanoramas(), EveningPanoramas()}, "panoramas", PanoramaOptionsOf("both"))
          .map);
  int same = 0;
  int localized = 0;
  size_t i = 0;
  const auto compare = [&](Verdict expected) {
    same += both[i] == expected;
    localized += both[i] == Verdict::kLocalized;
    ++i;
  };
  for (const Features& photo : FeaturesOfFrames()) {
    compare(LocalizeFeatures(*photos, photo, {}).verdict);
  }
  for (const cv::Mat& panorama : TheDrive().panoramas) {
    compare(LocalizePanorama(*panoramas, panorama, {}).verdict);
  }
  EXPECT_GE(same, std::ceil(0.98 * static_cast<double>(both.size())));
  EXPECT_GE(localized, std::ceil(0.9 * static_cast<double>(both.size())));
}

TEST(MixedMaps, TheOrderOfMapsDoesNotMatter) {
  EXPECT_TRUE(MergeMaps({Evening(), Morning()}, "both", PanoramaOptionsOf("both")).map ==
              Both().map);
}

// An added walk of photos changes nothing of the panoramas, and can go again.
TEST(MixedMaps, AnAddedWalkChangesItsOwnLayer) {
  const JoinResult grown = AddToMap(Morning(), SecondHalf(), PanoramaOptionsOf("grown"));
  EXPECT_GT(grown.report.keyframes_recognised, 0);
  EXPECT_EQ(grown.report.panoramas_recognised, 0);
  EXPECT_EQ(grown.map.appearance, Morning().appearance);
  Removal evening;
  const SequenceId added = grown.map.sequences.back().id;
  for (const Keyframe& keyframe : grown.map.keyframes) {
    if (keyframe.sequence == added) evening.keyframes.insert(keyframe.id);
  }
  evening.sequences = {added};
  const MapData left = RemoveFromMap(grown.map, evening, PanoramaOptionsOf("left")).map;
  EXPECT_EQ(left.keyframes, Morning().keyframes);
  EXPECT_EQ(left.appearance, Morning().appearance);
  EXPECT_TRUE(left.links.empty());
}

}  // namespace
}  // namespace waystone
