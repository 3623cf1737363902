// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/join_orientation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "builder/joining/merge_maps.h"
#include "builder/joining/remove_keyframes.h"
#include "builder/orientation/follow.h"
#include "core/geometry/angle.h"
#include "core/geometry/pose2.h"
#include "schema/sessions.h"
#include "tests/builder/joining/walked_maps.h"
#include "tests/builder/orientation/corner.h"

namespace waystone {
namespace {

// Every second image of the walk around the corner, from one on.
MapData ImagesOfEverySecond(int first, const std::string& name) {
  std::vector<cv::Mat> images;
  for (size_t i = first; i < Corner().images.size(); i += 2) images.push_back(Corner().images[i]);
  MapData map = MapWith(BuildOrientation(images).layer);
  map.info.name = name;
  map.info.program = "waystone";
  map.info.version = "sha256:" + name;
  map.sequences.front().name = name;
  map.sequences.front().camera = Corner().camera;
  return map;
}

const MapData& MorningWalk() {
  static const MapData map = ImagesOfEverySecond(0, "morning");
  return map;
}

// As if its first frame had settled other axes.
const MapData& EveningWalk() {
  static const MapData map = [] {
    MapData turned = ImagesOfEverySecond(1, "evening");
    TurnSequence({1}, 3, *turned.orientation);
    return turned;
  }();
  return map;
}

const JoinResult& JoinedWalks() {
  static const JoinResult joined = MergeMaps({MorningWalk(), EveningWalk()}, "joined", {});
  return joined;
}

TEST(JoinOrientation, TurnsWhatIsTiedIntoOneBuilding) {
  const OrientationLayer& layer = *JoinedWalks().map.orientation;
  EXPECT_GT(JoinedWalks().report.orientation_loops, 0);
  EXPECT_EQ(JoinedWalks().report.sequences_turned, 1);
  EXPECT_EQ(FindParts(JoinedWalks().map).size(), 1u);
  // "evening" comes first, so that its axes stay.
  const double building = -3 * kQuarterTurn_rad;
  int reliable = 0;
  for (const OrientationFrame& frame : layer.frames) {
    if (!frame.reliable) continue;
    ++reliable;
    const int first = frame.sequence == SequenceId{1} ? 1 : 0;
    const double off =
        WrappedAngle(*HeadingOf(frame) + building - TrueHeading(2 * frame.frame + first));
    EXPECT_LT(std::abs(off), 0.1) << frame.sequence.value << " " << frame.frame;
  }
  EXPECT_GT(reliable, 20);  // every second image turns too far for many frames
  EXPECT_EQ(layer.turns.size(),
            MorningWalk().orientation->turns.size() + EveningWalk().orientation->turns.size());
  EXPECT_EQ(WrittenAndRead(JoinedWalks().map).orientation, JoinedWalks().map.orientation);
}

TEST(JoinOrientation, TheOrderOfMapsDoesNotMatter) {
  EXPECT_EQ(MergeMaps({EveningWalk(), MorningWalk()}, "joined", {}).map, JoinedWalks().map);
}

TEST(JoinOrientation, FourQuarterTurnsAreNone) {
  OrientationLayer layer = *MorningWalk().orientation;
  for (int i = 0; i < 4; ++i) TurnSequence({1}, 1, layer);
  for (size_t i = 0; i < layer.frames.size(); ++i) {
    const OrientationFrame& before = MorningWalk().orientation->frames[i];
    EXPECT_EQ(layer.frames[i].lines, before.lines);
    if (!before.rotation) continue;
    EXPECT_TRUE(layer.frames[i].rotation->building_from_rig.isApprox(
        before.rotation->building_from_rig, 1e-9));
  }
  EXPECT_EQ(layer.turns, MorningWalk().orientation->turns);
  EXPECT_EQ(layer.corridors, MorningWalk().orientation->corridors);
}

TEST(RemoveFrames, ASessionLeavesTheOther) {
  const RemoveResult left = RemoveFromMap(JoinedWalks().map, {{}, {}, {{1}}}, {});
  EXPECT_EQ(left.report.orientation_frames,
            static_cast<int>(EveningWalk().orientation->frames.size()));
  EXPECT_EQ(left.map.orientation->frames.size(), MorningWalk().orientation->frames.size());
  EXPECT_EQ(left.map.sequences.size(), 1u);
  EXPECT_EQ(left.map.orientation->nodes.size(), MorningWalk().orientation->nodes.size());
  EXPECT_EQ(WrittenAndRead(left.map).orientation, left.map.orientation);
}

// Frames go with the keyframe or panorama that is nearest in their sequence.
TEST(RemoveFrames, GoWithTheNearestKeyframe) {
  MapData map = MorningWalk();
  for (const int frame : {0, 10, 20}) {
    Keyframe& keyframe = map.keyframes.emplace_back();
    keyframe.id = {frame + 1};
    keyframe.sequence = {1};
    keyframe.frame = frame;
  }
  const std::set<OrientationFrameId> going = FramesThatGo(map, {{{11}}, {}});
  for (const OrientationFrame& frame : map.orientation->frames) {
    EXPECT_EQ(going.contains(frame.id), frame.frame > 5 && frame.frame < 15) << frame.frame;
  }
  OrientationLayer& layer = *map.orientation;
  layer.corridors = {{layer.frames[8].id, layer.frames[30].id, 0}};
  RemoveFrames(going, map);
  ASSERT_EQ(layer.corridors.size(), 1u);
  EXPECT_EQ(layer.corridors.front().first, layer.frames[6].id);
}

}  // namespace
}  // namespace waystone
