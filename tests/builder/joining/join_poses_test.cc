// SPDX-License-Identifier: Apache-2.0
// Maps with poses that are joined, and that keyframes are removed from.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "builder/joining/merge_maps.h"
#include "builder/joining/remove_keyframes.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"
#include "core/geometry/angle.h"
#include "core/geometry/rotation.h"
#include "core/image/encode.h"
#include "localizer/poses/locate_pose.h"
#include "schema/layers/names/place_names.h"
#include "schema/layers/poses/horizontal.h"
#include "tests/builder/joining/walked_maps.h"

namespace waystone {
namespace {

MadeFrame Metres() { return {{}, LengthUnit::kMetres}; }

MadeFrame Turned() {
  MadeFrame frame;
  frame.from_world = {0.4, RotationByVector({0.3, -0.8, 1.1}), {7, -3, 2}, 0};
  return frame;
}

const MapData& InMetres() {
  static const MapData map = PosedMapOfFrames(0, 25, "metric", Metres());
  return map;
}

const MapData& InAnotherFrame() {
  static const MapData map = PosedMapOfFrames(16, 44, "turned", Turned());
  return map;
}

struct PoseErrors {
  int posed = 0;
  int near = 0;  // within 3 cm and half a degree
};

// Of every frame of the stage, against its true pose in the world.
PoseErrors AskAll(const MapData& map) {
  const auto index = MapIndex::Build(map);
  PoseErrors errors;
  for (size_t i = 0; i < FeaturesOfFrames().size(); ++i) {
    const Features& query = FeaturesOfFrames()[i];
    Answer answer = LocalizeFeatures(*index, query, {});
    AddPose(*index, query, TheStage().renderer.camera(), {}, answer);
    if (!answer.pose) continue;
    ++errors.posed;
    const Eigen::Isometry3d& truth = TheStage().walk.frames[i].world_from_camera;
    const Eigen::Isometry3d& pose = answer.pose->frame_from_camera;
    errors.near += (pose.translation() - truth.translation()).norm() < 0.03 &&
                   RotationAngle(pose.linear(), truth.linear()) < 0.5 / kDegreesPerRadian;
  }
  return errors;
}

// Features of planes that have a pose whose depth isn't known, and all of them.
std::pair<int, int> CountUnknownDepths(const MapData& map) {
  int unknown = 0;
  int all = 0;
  for (const PlaneDepths& depths : map.poses->plane_depths) {
    if (!std::ranges::binary_search(map.poses->planes, depths.plane, {}, &PlanePose::plane)) {
      continue;
    }
    for (const DepthCode& code : depths.features) {
      ++all;
      unknown += !code.known();
    }
  }
  return {unknown, all};
}

TEST(JoinPoses, FramesOfTwoMapsBecomeOne) {
  const JoinResult joined = MergeMaps({InAnotherFrame(), InMetres()}, "joined", {});
  const MapData& map = joined.map;
  ASSERT_TRUE(map.poses);
  EXPECT_EQ(map.poses->frame, "metric's");
  EXPECT_EQ(map.poses->unit, LengthUnit::kMetres);
  EXPECT_EQ(map.poses->keyframes.size(), map.keyframes.size());
  for (const KeyframePose& pose : map.poses->keyframes) {
    const auto keyframe = std::ranges::find(map.keyframes, pose.keyframe, &Keyframe::id);
    const Eigen::Isometry3d truth = TheStage().walk.frames[keyframe->frame].world_from_camera;
    EXPECT_LT((pose.position - truth.translation()).norm(), 0.03) << keyframe->source;
    EXPECT_LT(RotationAngle(pose.rotation.toRotationMatrix(), truth.linear()),
              0.5 / kDegreesPerRadian);
  }
  EXPECT_EQ(WrittenAndRead(map).poses, map.poses);
  const PoseErrors errors = AskAll(map);
  EXPECT_GE(errors.posed, 40);
  EXPECT_GE(errors.near, errors.posed - 3);
  EXPECT_TRUE(MergeMaps({InMetres(), InAnotherFrame()}, "joined", {}).map == map);
}

// Their pictures are asked for with the camera of the pictures.
TEST(JoinPoses, ImagesMayHaveBeenLargerThanKeyframes) {
  const auto of_large_images = [](MapData map) {
    for (Sequence& sequence : map.sequences) {
      sequence.camera = ScaledCamera(*sequence.camera, 3 * sequence.camera->width);
    }
    return map;
  };
  const MapData map =
      MergeMaps({of_large_images(InAnotherFrame()), of_large_images(InMetres())}, "joined", {}).map;
  for (const KeyframePose& pose : map.poses->keyframes) {
    const auto keyframe = std::ranges::find(map.keyframes, pose.keyframe, &Keyframe::id);
    const Eigen::Isometry3d truth = TheStage().walk.frames[keyframe->frame].world_from_camera;
    EXPECT_LT((pose.position - truth.translation()).norm(), 0.03) << keyframe->source;
  }
}

// An area around a keyframe stays around it.
TEST(JoinPoses, AreasComeIntoTheFrameOfTheMap) {
  MapData turned = InAnotherFrame();
  const KeyframePose& pose = turned.poses->keyframes[3];
  const Eigen::Vector2d at = HorizontalOf(*turned.poses).Of(pose.position);
  const double half = 0.4 * 0.2;  // 20 cm in its unit
  turned.names = {{"Here",
                   {},
                   {{at + Eigen::Vector2d(-half, -half), at + Eigen::Vector2d(half, -half),
                     at + Eigen::Vector2d(half, half), at + Eigen::Vector2d(-half, half)}}}};
  const std::string source = turned.keyframes[3].source;
  const MapData joined = MergeMaps({turned, InMetres()}, "joined", {}).map;
  ASSERT_EQ(joined.names.size(), 1u);
  const NamedPolygon& area = joined.names[0].polygons.at(0);
  EXPECT_NEAR(AreaOf(area), 0.4 * 0.4, 0.02);
  int inside = 0;
  for (const Keyframe& keyframe : joined.keyframes) {
    if (keyframe.source != source) continue;
    const KeyframePose* found = joined.poses->Find(keyframe.id);
    ASSERT_NE(found, nullptr);
    inside += Holds(area, HorizontalOf(*joined.poses).Of(found->position));
  }
  EXPECT_GE(inside, 1);
  EXPECT_EQ(WrittenAndRead(joined).names, joined.names);
}

// Anchors hold in the frame of their map alone.
TEST(JoinPoses, PlansOfTheFrameThatIsKeptStay) {
  const auto plan = [](const std::string& name) {
    FloorPlanImage made;
    made.name = name;
    made.width = 8;
    made.height = 8;
    made.anchors = {{{0, 8}, {0, 0}}, {{8, 8}, {20, 0}}};
    made.image = EncodeJpeg(cv::Mat(8, 8, CV_8UC1, cv::Scalar(240)));
    return made;
  };
  MapData metric = InMetres(), turned = InAnotherFrame();
  metric.floor_plans = {plan("Metric")};
  turned.floor_plans = {plan("Turned")};
  const JoinResult joined = MergeMaps({turned, metric}, "joined", {});
  EXPECT_EQ(joined.map.floor_plans, metric.floor_plans);
  EXPECT_EQ(joined.report.floor_plans, std::vector<std::string>{"Turned"});
  EXPECT_EQ(WrittenAndRead(joined.map).floor_plans, metric.floor_plans);
  const JoinResult added = AddToMap(turned, metric, {});
  EXPECT_EQ(added.map.floor_plans, turned.floor_plans);
  EXPECT_EQ(added.report.floor_plans, std::vector<std::string>{"Metric"});
  const KeyframeId first = metric.keyframes.front().id;
  EXPECT_EQ(RemoveFromMap(metric, {{first}, {}}, {}).map.floor_plans, metric.floor_plans);
  std::set<KeyframeId> all;  // of the only walk with poses
  const JoinResult half = MergeMaps({metric, MapOfFrames(16, 44, "plain")}, "half", {});
  for (const KeyframePose& pose : half.map.poses->keyframes) all.insert(pose.keyframe);
  const RemoveResult left = RemoveFromMap(half.map, {all, {}}, {});
  EXPECT_TRUE(left.map.floor_plans.empty());
  EXPECT_EQ(left.report.floor_plans, std::vector<std::string>{"Metric"});
}

// Whoever has stored positions of a map finds them again.
TEST(JoinPoses, AnAddedWalkComesIntoTheFrameOfTheMap) {
  const MapData& before = InAnotherFrame();
  const MapData map = AddToMap(before, InMetres(), {}).map;
  ASSERT_TRUE(map.poses);
  EXPECT_EQ(map.poses->frame, "turned's");
  EXPECT_EQ(map.poses->unit, LengthUnit::kUnknown);
  EXPECT_EQ(map.poses->keyframes.size(), map.keyframes.size());
  for (const KeyframePose& pose : before.poses->keyframes) {
    EXPECT_EQ(*map.poses->Find(pose.keyframe), pose);
  }
  for (const KeyframePose& pose : map.poses->keyframes) {
    const auto keyframe = std::ranges::find(map.keyframes, pose.keyframe, &Keyframe::id);
    const Eigen::Isometry3d truth =
        Turned().Of(TheStage().walk.frames[keyframe->frame].world_from_camera);
    EXPECT_LT((pose.position - truth.translation()).norm(), 0.4 * 0.03) << keyframe->source;
  }
}

TEST(JoinPoses, AMapWithoutPosesLeavesTheOthersAsTheyAre) {
  const MapData joined = MergeMaps({InMetres(), MapOfFrames(24, 44, "plain")}, "joined", {}).map;
  ASSERT_TRUE(joined.poses);
  EXPECT_EQ(joined.poses->keyframes.size(), InMetres().poses->keyframes.size());
  EXPECT_EQ(WrittenAndRead(joined).poses, joined.poses);
  // Answers with keyframes of the other map have none, and photos from beyond the posed walk have
  // uncertain ones, in either map.
  const PoseErrors errors = AskAll(joined);
  const PoseErrors alone = AskAll(InMetres());
  EXPECT_GE(errors.near, std::max(20, alone.near));
  EXPECT_LE(errors.posed - errors.near, alone.posed - alone.near);
}

TEST(JoinPoses, FramesThatNothingTiesTogetherAreRefused) {
  const World world(DemoPlan(), {.seed = 77, .texture_richness = 0.5});
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 15; ++i) {
    frames.push_back(
        TheStage().renderer.Render(world, TheStage().walk.frames[i].world_from_camera).grey);
  }
  GivenPoses poses;
  poses.of_image = [](const Sequence&, const FrameInfo& image) {
    return TheStage().walk.frames[image.number].world_from_camera;
  };
  const MapData elsewhere = MapOfImages(frames, 0, 14, "elsewhere", FeatureType::kSift, poses);
  try {
    MergeMaps({InMetres(), elsewhere}, "both", {});
    FAIL() << "joined";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadRequest);
    EXPECT_EQ(std::string(error.what()),
              "map 'elsewhere' and map 'metric' have poses in frames that can't be aligned: fewer "
              "than 3 keyframes or panoramas, or less than half, agree on how they lie; build one "
              "of them without --poses");
  }
}

TEST(RemoveKeyframes, LeavesThePosesOfTheOthers) {
  const MapData& before = InMetres();
  const KeyframeId first = before.keyframes.front().id;
  const RemoveResult left = RemoveFromMap(before, {{first}, {}}, {});
  ASSERT_TRUE(left.map.poses);
  EXPECT_GT(left.report.planes_anchored, 0);
  EXPECT_EQ(left.map.poses->keyframes.size() + 1, before.poses->keyframes.size());
  EXPECT_EQ(left.map.poses->Find(first), nullptr);
  EXPECT_EQ(WrittenAndRead(left.map).poses, left.map.poses);
  // Planes that are expressed in another image still know where their features are, by their pose.
  const auto [unknown_before, all_before] = CountUnknownDepths(before);
  const auto [unknown, all] = CountUnknownDepths(left.map);
  EXPECT_GT(all, all_before / 2);
  EXPECT_LE(unknown, unknown_before);
  const PoseErrors errors = AskAll(left.map);
  EXPECT_GE(errors.near, AskAll(before).near - 4);
}

TEST(RemoveKeyframes, NoPosesAreLeftWithoutPosedKeyframes) {
  const MapData joined = MergeMaps({InMetres(), MapOfFrames(16, 44, "plain")}, "joined", {}).map;
  std::set<KeyframeId> posed;
  for (const KeyframePose& pose : joined.poses->keyframes) posed.insert(pose.keyframe);
  const MapData left = RemoveFromMap(joined, {posed, {}}, {}).map;
  EXPECT_FALSE(left.poses);
  EXPECT_FALSE(left.keyframes.empty());
}

}  // namespace
}  // namespace waystone
