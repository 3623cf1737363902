// SPDX-License-Identifier: Apache-2.0
// What a whole walk becomes in the orientation layer.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "schema/file/map_problems.h"
#include "schema/layers/orientation/unknown_corridors.h"
#include "tests/builder/orientation/corner.h"

namespace waystone {
namespace {

TEST(OrientationMapTest, FindsTheTurnTheHeadingsAndTheWay) {
  const BuiltOrientation result = BuildOrientation(Corner().images);
  const OrientationLayer& layer = result.layer;
  ASSERT_EQ(layer.frames.size(), Corner().images.size());
  // A narrow view of upright lines mostly: many frames are believed by the features' rotation, up
  // to FollowOptions::max_drift_rad and what that is off itself.
  int reliable = 0;
  int exact = 0;
  for (size_t i = 0; i < layer.frames.size(); ++i) {
    if (!layer.frames[i].reliable) continue;
    ++reliable;
    const double off =
        std::abs(HeadingOf(layer.frames[i]).value() - TrueHeading(static_cast<int>(i)));
    EXPECT_LT(off, 0.1) << i;
    exact += off < 0.05 ? 1 : 0;
  }
  EXPECT_GT(reliable, 0.5 * static_cast<double>(layer.frames.size()));
  EXPECT_GT(exact, 0.95 * reliable);
  ASSERT_EQ(layer.turns.size(), 1U);
  EXPECT_TRUE(layer.turns[0].confirmed);
  EXPECT_EQ(layer.turns[0].direction, -1);
  EXPECT_EQ(layer.turns[0].axis_after, 1);
  EXPECT_NEAR(TrueHeading(static_cast<int>(layer.turns[0].frame.value - 1)), -0.785, 0.2);
  EXPECT_GE(layer.nodes.size(), 3U);
  EXPECT_GE(layer.edges.size(), 2U);
  EXPECT_FALSE(layer.nodes[0].picture.empty());
  std::vector<MapProblem> problems = FindMapProblems(MapWith(layer));
  EXPECT_TRUE(problems.empty()) << problems[0].where << ": " << problems[0].message;
}

// Both legs of this walk are corridors, which one camera can't tell from rooms: it doesn't guess.
TEST(OrientationMapTest, OneCameraNamesNoCorridors) {
  EXPECT_TRUE(BuildOrientation(Corner().images).layer.corridors.empty());
  const Sequence narrow{
      .id = {1}, .name = "corner", .kind = kFolderKind, .camera = Corner().camera};
  EXPECT_FALSE(SeesAllAround(narrow));
  Sequence wide = narrow;
  wide.camera = PanoramaCamera(512);
  EXPECT_TRUE(SeesAllAround(wide));
  wide.camera.reset();
  EXPECT_TRUE(SeesAllAround(wide));
  Sequence rig = narrow;
  rig.kind = kRigKind;
  EXPECT_TRUE(SeesAllAround(rig));
}

TEST(OrientationMapTest, CorridorsAreUnknownOnlyWhereOneCameraHasFramesOfTheLayer) {
  MapData map = MapWith({});
  map.sequences[0].camera = Corner().camera;
  EXPECT_TRUE(ListSequencesWithUnknownCorridors(map).empty());
  map.orientation->frames.push_back(
      {.id = {1}, .sequence = {1}, .source = "0", .time_s = {}, .rotation = {}});
  EXPECT_EQ(ListSequencesWithUnknownCorridors(map), std::vector{SequenceId{1}});
  map.sequences[0].kind = kRigKind;
  EXPECT_TRUE(ListSequencesWithUnknownCorridors(map).empty());
  map.orientation.reset();
  EXPECT_TRUE(ListSequencesWithUnknownCorridors(map).empty());
}

// The camera turns the corner in the dark: which way it looks then can't be told from axes alone.
TEST(OrientationMapTest, AQuarterTurnIsNotGuessedOverAGap) {
  std::vector<cv::Mat> images = Corner().images;
  int turns = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    const double heading = std::abs(TrueHeading(static_cast<int>(i)));
    if (heading < 0.15 || heading > 1.4) continue;
    images[i] = cv::Mat(240, 320, CV_8UC1, cv::Scalar(0));
    ++turns;
  }
  ASSERT_GT(turns, 5);
  const BuiltOrientation result = BuildOrientation(images);
  for (size_t i = 0; i < images.size(); ++i) {
    const OrientationFrame& frame = result.layer.frames[i];
    if (!frame.reliable) continue;
    EXPECT_NEAR(*HeadingOf(frame), TrueHeading(static_cast<int>(i)), 0.1) << i;
  }
  EXPECT_TRUE(FindMapProblems(MapWith(result.layer)).empty());
}

}  // namespace
}  // namespace waystone
