// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/remove_keyframes.h"

#include <gtest/gtest.h>

#include "builder/joining/merge_maps.h"
#include "core/base/error.h"
#include "schema/sessions.h"
#include "tests/builder/joining/walked_maps.h"

namespace waystone {
namespace {

const MapData& TwoSessions() {
  static const MapData map =
      MergeMaps({MapOfFrames(0, 25, "first"), MapOfFrames(18, 44, "second")}, "joined", {}).map;
  return map;
}

std::set<KeyframeId> KeyframesOf(const MapData& map, SequenceId sequence) {
  std::set<KeyframeId> ids;
  for (const Keyframe& keyframe : map.keyframes) {
    if (keyframe.sequence == sequence) ids.insert(keyframe.id);
  }
  return ids;
}

int CountLocalized(const MapData& map, int first, int last) {
  const auto index = MapIndex::Build(map);
  int localized = 0;
  for (int i = first; i <= last; ++i) {
    localized += LocalizeFeatures(*index, FeaturesOfFrames()[i], {}).verdict == Verdict::kLocalized;
  }
  return localized;
}

TEST(RemoveKeyframes, OfASessionLeavesTheOther) {
  const MapData& both = TwoSessions();
  const bool first_leads = SessionsOf(both)[0].name == "first";
  const SequenceId second{first_leads ? 2 : 1};
  const RemoveResult left = RemoveFromMap(both, {KeyframesOf(both, second), {}}, {});
  EXPECT_EQ(left.report.sequences, 1);
  EXPECT_GT(left.report.planes, 0);
  ASSERT_EQ(SessionsOf(left.map).size(), 1u);
  EXPECT_EQ(SessionsOf(left.map)[0].name, "first");
  EXPECT_EQ(left.map.keyframes.size() + left.report.keyframes, both.keyframes.size());
  const MapData read = WrittenAndRead(left.map);
  EXPECT_EQ(read.planes, left.map.planes);
  // What the first session showed is still found.
  EXPECT_GE(CountLocalized(left.map, 0, 20), 18);
}

TEST(RemoveKeyframes, ExpressesPlanesInAnotherReference) {
  const MapData& map = TheMap().map;
  const KeyframeId first = map.keyframes.front().id;
  const RemoveResult left = RemoveFromMap(map, {{first}, {}}, {});
  EXPECT_GT(left.report.planes_anchored, 0);
  for (const Plane& plane : left.map.planes) {
    EXPECT_NE(plane.reference, first);
    const auto before = std::ranges::find(map.planes, plane.id, &Plane::id);
    if (before->reference != first) continue;
    // A feature that both have is where the homography puts it.
    const PlaneView& view = before->views[1];
    ASSERT_EQ(view.keyframe, plane.reference);
    const Eigen::Matrix3d to_from = view.reference_from_keyframe.inverse();
    std::set<std::pair<float, float>> expected;
    for (const PlaneFeature& feature : before->features) {
      const Eigen::Vector2d x =
          (to_from * Eigen::Vector3d(feature.reference.x_px, feature.reference.y_px, 1))
              .hnormalized();
      expected.emplace(static_cast<float>(x.x()), static_cast<float>(x.y()));
    }
    for (const PlaneFeature& feature : plane.features) {
      EXPECT_TRUE(expected.contains({feature.reference.x_px, feature.reference.y_px}));
    }
  }
  EXPECT_EQ(WrittenAndRead(left.map).edges, left.map.edges);
}

// The second of three keyframes has gone past the features, which its homography puts upside down
// into its image.
TEST(RemoveKeyframes, WhatIsBehindAKeyframeIsNotShownByIt) {
  MapData map = MapOfFrames(0, 20, "first");
  ASSERT_GE(map.keyframes.size(), 3U);
  for (Keyframe& keyframe : map.keyframes) keyframe.picture.clear();  // nothing to calibrate by
  map.edges.clear();
  Plane& plane = map.planes.front();
  Eigen::Matrix3d second_from_first;
  second_from_first << 1 - 400 / 160.0, 0, 400, -250 / 160.0, 1, 250, -1 / 160.0, 0, 1;
  const auto id = [&](size_t k) { return map.keyframes[k].id; };
  plane.reference = id(0);
  plane.views = {{id(0), Eigen::Matrix3d::Identity(), 40},
                 {id(1), second_from_first.inverse(), 40},
                 {id(2), Eigen::Matrix3d::Identity(), 40}};
  plane.features.clear();
  Descriptors descriptors(plane.descriptors.bytes());
  for (int i = 0; i < 40; ++i) {
    const Keypoint at{290, 100.0F + static_cast<float>(i), 8, 0};
    const Eigen::Vector3d there = second_from_first * Eigen::Vector3d(at.x_px, at.y_px, 1);
    ASSERT_LT(there.z(), 0) << "behind";
    const Eigen::Vector2d x = there.hnormalized();
    ASSERT_TRUE(x.x() > 0 && x.y() > 0 && x.x() < 320 && x.y() < 240) << x.transpose();
    plane.features.push_back({at, 3, 3});
    descriptors.Append(std::vector<uint8_t>(128, static_cast<uint8_t>(i)).data());
  }
  plane.descriptors = descriptors;
  map.index.reset();
  const MapData left = RemoveFromMap(map, {{id(2)}, {}}, {}).map;
  ASSERT_EQ(left.planes.front().features.size(), 40U);
  for (const PlaneFeature& feature : left.planes.front().features) EXPECT_EQ(feature.visible, 1);
}

TEST(RemoveKeyframes, KeepsWhatIsLeftOfNamedPlaces) {
  MapData map = TheMap().map;
  map.names = {{"Begin", {{NamedKind::kKeyframes, 1, 1}}, {}},
               {"Hall", {{NamedKind::kKeyframes, 1, 4}}, {}}};
  const RemoveResult left = RemoveFromMap(map, {{{1}, {3}}, {}}, {});
  EXPECT_EQ(left.report.names, std::vector<std::string>{"Begin"});
  ASSERT_EQ(left.map.names.size(), 1u);
  EXPECT_EQ(left.map.names[0], (NamedPlace{"Hall", {{NamedKind::kKeyframes, 2, 4}}, {}}));
}

TEST(RemoveKeyframes, ParesAStretchInTwo) {
  const MapData& map = TheMap().map;
  const size_t middle = map.keyframes.size() / 2;
  const RemoveResult left = RemoveFromMap(map, {{map.keyframes[middle].id}, {}}, {});
  EXPECT_LT(left.map.keyframes[middle - 1].stretch, left.map.keyframes[middle].stretch);
  EXPECT_EQ(left.map.keyframes.front().stretch, 0);
}

TEST(RemoveKeyframes, RefusesUnknownOnesAndAll) {
  const MapData& map = TheMap().map;
  try {
    RemoveFromMap(map, {{{9999}}, {}}, {});
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotFound);
    EXPECT_EQ(std::string(error.what()), "the map has no keyframe 9999; its keyframes are 1 to " +
                                             std::to_string(map.keyframes.back().id.value));
  }
  try {
    RemoveFromMap(map, {KeyframesOf(map, {1}), {}}, {});
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadRequest);
  }
}

}  // namespace
}  // namespace waystone
