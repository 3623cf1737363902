// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/landmarks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "core/features/descriptor_codes.h"
#include "core/homography/homography.h"
#include "tests/builder/planes/made_scene.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

// Points at all depths ahead of a camera that goes aside.
LandmarkOptions Keep(int max_kept, int lone_per_found = LandmarkOptions{}.lone_per_found) {
  LandmarkOptions options;
  options.max_kept = max_kept;
  options.lone_per_found = lone_per_found;
  return options;
}

// The first of them.
Features Part(const Features& features, int most) {
  Features part = features;
  part.keypoints.resize(std::min(features.size(), most));
  part.descriptors = Descriptors(features.descriptors.bytes());
  for (int i = 0; i < part.size(); ++i) part.descriptors.Append(features.descriptors.row(i));
  return part;
}

class LandmarksTest : public testing::Test {
 protected:
  LandmarksTest() {
    for (int depth = 0; depth < 20; ++depth) {
      const double z = 4 + 0.3 * depth;
      scene_.AddWall({{-3, -2, z}, {6, 0, 0.1}, {0, 4, 0}}, 20);
    }
  }

  // Adds what the camera sees at x, with `clutter` features that are nowhere else.
  void See(LandmarkChooser& chooser, double x, bool starts_stretch, int clutter = 100,
           double yaw_rad = 0, int of_scene = 10'000) {
    Features features = Part(scene_.See(PoseAt(x, 0, 0, yaw_rad)), of_scene);
    for (int i = 0; i < clutter; ++i) {
      features.keypoints.push_back({static_cast<float>(scene_.random().Uniform(0, 640)),
                                    static_cast<float>(scene_.random().Uniform(0, 480)), 8, 0});
      features.descriptors.Append(RandomDescriptor(scene_.random()).data());
    }
    Keyframe keyframe;
    keyframe.id = {std::ssize(map_.keyframes) + 1};
    keyframe.width = features.width;
    keyframe.height = features.height;
    chooser.Add(keyframe.id, features, starts_stretch);
    map_.keyframes.push_back(keyframe);
  }

  // Landmarks of a keyframe whose code is that of a point of the scene.
  int CountOfScene(const Keyframe& keyframe) const {
    std::set<std::vector<uint8_t>> codes;
    for (const MadePoint& point : scene_.points()) {
      const Descriptors code =
          EncodeDescriptors(Descriptors(128, point.descriptor), FeatureType::kSift);
      codes.insert(code.data());
    }
    int count = 0;
    for (int i = 0; i < keyframe.landmarks.size(); ++i) {
      const uint8_t* row = keyframe.landmarks.codes.row(i);
      count += codes.contains({row, row + keyframe.landmarks.codes.bytes()});
    }
    return count;
  }

  MadeScene scene_{1};
  MapData map_;
};

TEST_F(LandmarksTest, KeepsWhatWasFoundAgain) {
  LandmarkChooser chooser(Keep(80));
  for (int i = 0; i < 5; ++i) See(chooser, 0.2 * i, i == 0);
  chooser.Finish(map_);
  for (const Keyframe& keyframe : map_.keyframes) {
    EXPECT_EQ(keyframe.landmarks.size(), 80);
    EXPECT_EQ(keyframe.landmarks.codes.rows(), 80);
    EXPECT_GE(CountOfScene(keyframe), 78);
  }
}

TEST_F(LandmarksTest, KeepsWhatATurningCameraFoundAgain) {
  LandmarkChooser chooser(Keep(80));
  for (int i = 0; i < 4; ++i) See(chooser, 0, i == 0, 100, 0.1 * i);
  chooser.Finish(map_);
  for (const Keyframe& keyframe : map_.keyframes) EXPECT_GE(CountOfScene(keyframe), 78);
}

TEST_F(LandmarksTest, SpreadsThemOverTheImage) {
  LandmarkChooser chooser(Keep(60));
  for (int i = 0; i < 3; ++i) See(chooser, 0.2 * i, i == 0);
  chooser.Finish(map_);
  for (const Keyframe& keyframe : map_.keyframes) {
    std::map<std::pair<int, int>, int> quarters;
    for (const ImagePosition& position : keyframe.landmarks.positions) {
      const Vector2d x = DecodePosition(position, keyframe.width, keyframe.height);
      ++quarters[{x.x() < 320, x.y() < 240}];
    }
    ASSERT_EQ(quarters.size(), 4u);
    for (const auto& [quarter, count] : quarters) EXPECT_GE(count, 8);
  }
}

TEST_F(LandmarksTest, LeavesFeaturesOfPlanesToThem) {
  LandmarkChooser chooser(Keep(1000, 0));
  for (int i = 0; i < 3; ++i) See(chooser, 0.2 * i, i == 0, 0);
  Plane plane;
  plane.id = {1};
  plane.reference = {1};
  const Features first = scene_.See(PoseAt(0, 0, 0), 0);
  for (const Keypoint& keypoint : first.keypoints) plane.features.push_back({keypoint, 3, 3});
  plane.views = {{{1}, Eigen::Matrix3d::Identity(), 10}};
  map_.planes.push_back(plane);
  chooser.Finish(map_);
  EXPECT_LE(map_.keyframes[0].landmarks.size(), 3);
  EXPECT_GE(map_.keyframes[1].landmarks.size(), 200);
}

TEST_F(LandmarksTest, AStretchBeginsAnew) {
  LandmarkChooser chooser(Keep(80, 0));
  See(chooser, 0, true);
  See(chooser, 0.2, true);
  chooser.Finish(map_);
  for (const Keyframe& keyframe : map_.keyframes) EXPECT_EQ(keyframe.landmarks.size(), 0);
}

TEST_F(LandmarksTest, APhotoAloneKeepsSeveralForEachThatIsMissing) {
  LandmarkChooser chooser(Keep(60, 4));
  See(chooser, 0, true, 300);
  for (int i = 0; i < 2; ++i) See(chooser, 0.2 * i, i == 0, 300);
  chooser.Finish(map_);
  EXPECT_EQ(map_.keyframes[0].landmarks.size(), 240);
  for (int i = 1; i < 3; ++i) EXPECT_EQ(map_.keyframes[i].landmarks.size(), 60) << i;
}

// Neighbours that show little of what it shows leave room for others, as far as no plane has them.
TEST_F(LandmarksTest, OthersMakeUpForWhatIsMissing) {
  constexpr int kShared = 40;
  constexpr int kOfPlane = 20;
  LandmarkChooser chooser(Keep(100, 3));
  for (int i = 0; i < 2; ++i) See(chooser, 0, i == 0, 400, 0, kShared);
  const Features shared = Part(scene_.See(PoseAt(0, 0, 0), 0), kShared);
  Plane plane;
  plane.id = {1};
  plane.reference = {1};
  for (int i = 0; i < kOfPlane; ++i) plane.features.push_back({shared.keypoints[i], 3, 3});
  plane.views = {{{1}, Eigen::Matrix3d::Identity(), 10}};
  map_.planes.push_back(plane);
  chooser.Finish(map_);
  EXPECT_NEAR(map_.keyframes[0].landmarks.size(), kShared - kOfPlane + 3 * (100 - kShared), 12);
  EXPECT_NEAR(map_.keyframes[1].landmarks.size(), kShared + 3 * (100 - kShared), 12);
}

TEST_F(LandmarksTest, NoneKeepsNone) {
  LandmarkChooser chooser(Keep(0));
  for (int i = 0; i < 3; ++i) See(chooser, 0.2 * i, i == 0);
  chooser.Finish(map_);
  for (const Keyframe& keyframe : map_.keyframes) EXPECT_EQ(keyframe.landmarks.size(), 0);
}

TEST(ImagePosition, IsKeptToAFractionOfAPixel) {
  for (const Vector2d& x : {Vector2d(0, 0), Vector2d(639.5, 479.25), Vector2d(123.4, 321.9)}) {
    EXPECT_LT((DecodePosition(EncodePosition(x, 640, 480), 640, 480) - x).norm(), 0.01);
  }
  EXPECT_EQ(EncodePosition({-5, 481}, 640, 480), (ImagePosition{0, 65535}));
}

TEST(LandmarkOptions, BadValuesAreRefused) {
  EXPECT_THROW(Keep(-1).Check(), MapError);
  EXPECT_THROW(Keep(100, 11).Check(), MapError);
  LandmarkOptions options;
  options.neighbours = 0;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
