// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/planes/keyframe_camera.h"

#include <gtest/gtest.h>

namespace waystone {
namespace {

MapData MapOfOneKeyframe(int width, int height) {
  MapData map;
  Sequence sequence;
  sequence.id = SequenceId{3};
  sequence.camera = Camera{CameraModel::kPinhole, 4000, 3000, {3200, 3200, 1999.5, 1499.5}};
  map.sequences.push_back(sequence);
  Keyframe keyframe;
  keyframe.id = KeyframeId{7};
  keyframe.sequence = SequenceId{3};
  keyframe.width = width;
  keyframe.height = height;
  map.keyframes.push_back(keyframe);
  return map;
}

TEST(KeyframeCamera, HasThePixelsOfTheKeyframe) {
  const MapData map = MapOfOneKeyframe(1000, 750);
  const Camera expected{CameraModel::kPinhole, 1000, 750, {800, 800, 499.5, 374.5}};
  EXPECT_EQ(CameraOfKeyframe(map, KeyframeId{7}), expected);
  EXPECT_EQ(CameraOfKeyframe(map.sequences[0], map.keyframes[0]), expected);
}

TEST(KeyframeCamera, IsTheSequencesOwnForOriginalImages) {
  const MapData map = MapOfOneKeyframe(4000, 3000);
  EXPECT_EQ(CameraOfKeyframe(map, KeyframeId{7}), map.sequences[0].camera);
}

TEST(KeyframeCamera, IsNothingWithoutOne) {
  MapData map = MapOfOneKeyframe(1000, 750);
  EXPECT_FALSE(CameraOfKeyframe(map, KeyframeId{8}));
  map.sequences[0].camera.reset();
  EXPECT_FALSE(CameraOfKeyframe(map, KeyframeId{7}));
  map.sequences.clear();
  EXPECT_FALSE(CameraOfKeyframe(map, KeyframeId{7}));
}

}  // namespace
}  // namespace waystone
