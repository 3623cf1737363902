// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/traversability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>

#include "builder/orientation/follow.h"
#include "builder/orientation/loops.h"
#include "core/base/random.h"

namespace waystone {
namespace {

// Points around a rig in a room of 8 x 6 x 3 m, each with a descriptor of its own.
class Room {
 public:
  explicit Room(uint64_t seed) : seed_(seed) {
    Random random(seed);
    for (int i = 0; i < 300; ++i) {
      points_.emplace_back(random.Uniform(-4, 4), random.Uniform(-3, 3), random.Uniform(-1.5, 1.5));
    }
  }

  // What a rig at a place with a heading sees: x ahead, y left, z up of the building.
  BearingFeatures From(const Eigen::Vector3d& place, double heading_rad) const {
    BearingFeatures features;
    features.descriptors = Descriptors(DescriptorBytes(features.type));
    const Eigen::Quaterniond rig_from_building = RotationAt(heading_rad).conjugate();
    for (size_t i = 0; i < points_.size(); ++i) {
      features.rays.push_back((rig_from_building * (points_[i] - place)).normalized());
      features.camera.push_back(0);
      features.keypoints.emplace_back();
      Random random(seed_ * 1000 + i);
      std::vector<uint8_t> row(DescriptorBytes(features.type));
      for (uint8_t& byte : row) byte = static_cast<uint8_t>(random.Below(60));
      features.descriptors.Append(row.data());
    }
    return features;
  }

  static Eigen::Quaterniond RotationAt(double heading_rad) {
    Eigen::Matrix3d looking_along_x;
    looking_along_x << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()) *
           Eigen::Quaterniond(looking_along_x);
  }

 private:
  uint64_t seed_;
  std::vector<Eigen::Vector3d> points_;
};

OrientationFrame FrameOf(int frame, double heading_rad) {
  BuildingRotation rotation{.building_from_rig = Room::RotationAt(heading_rad),
                            .covariance = 1e-6 * Eigen::Matrix3d::Identity()};
  return {.id = {frame + 1},
          .sequence = {1},
          .frame = frame,
          .source = "",
          .time_s = {},
          .reliable = true,
          .rotation = rotation,
          .lines = {}};
}

TEST(Traversability, TellsRotationMotionAndTheFeaturesFlow) {
  const Room room(1);
  const BearingFeatures a = room.From({0, 0, 0}, 0.1);
  for (const double turn : {0.3, -0.3}) {
    const BearingFeatures b = room.From({0.3, 0.4, 0}, 0.1 + turn);
    const OrientationFrame frame_a = FrameOf(0, 0.1);
    const OrientationFrame frame_b = FrameOf(1, 0.1 + turn);
    const Traversal t = TestTraversability({&a, &frame_a}, {&b, &frame_b});
    EXPECT_TRUE(t.connected);
    EXPECT_GT(t.matches, 200);
    EXPECT_LT(t.disagreement_rad.value(), 0.01);
    EXPECT_NEAR(t.motion_rad.value(), std::atan2(0.4, 0.3), 0.02);
    // The rig turns to the left: what it sees moves to the right.
    EXPECT_LT(t.flow_rad * turn, 0);
  }
}

TEST(Traversability, AHeadThatTurnsOnTheSpotHasNoMotion) {
  const Room room(1);
  const BearingFeatures a = room.From({0, 0, 0}, 0);
  const BearingFeatures b = room.From({0.0001, 0, 0}, 0.4);
  const OrientationFrame frame_a = FrameOf(0, 0);
  const OrientationFrame frame_b = FrameOf(1, 0.4);
  EXPECT_FALSE(TestTraversability({&a, &frame_a}, {&b, &frame_b}).motion_rad);
}

TEST(Traversability, ARotationThatTheAxesContradictDoesNotConnect) {
  const Room room(1);
  const BearingFeatures a = room.From({0, 0, 0}, 0);
  const BearingFeatures b = room.From({0.5, 0, 0}, 0);
  const OrientationFrame frame_a = FrameOf(0, 0);
  OrientationFrame frame_b = FrameOf(1, 0.3);
  EXPECT_FALSE(TestTraversability({&a, &frame_a}, {&b, &frame_b}).connected);
  // By a quarter turn they agree: axes may be numbered differently.
  frame_b = FrameOf(1, std::numbers::pi / 2);
  EXPECT_TRUE(TestTraversability({&a, &frame_a}, {&b, &frame_b}).connected);
  // And unreliable axes contradict nothing.
  frame_b = FrameOf(1, 0.3);
  frame_b.reliable = false;
  EXPECT_TRUE(TestTraversability({&a, &frame_a}, {&b, &frame_b}).connected);
}

TEST(Traversability, AnotherRoomOrNoFeaturesDoNotConnect) {
  const BearingFeatures a = Room(1).From({0, 0, 0}, 0);
  const BearingFeatures other = Room(2).From({0, 0, 0}, 0);
  const BearingFeatures none;
  const OrientationFrame frame = FrameOf(0, 0);
  EXPECT_FALSE(TestTraversability({&a, &frame}, {&other, &frame}).connected);
  EXPECT_FALSE(TestTraversability({&a, &frame}, {&none, &frame}).connected);
}

TEST(Loops, JoinAPlaceWithWhatItWasLongBefore) {
  const std::vector<BearingFeatures> features{
      Room(1).From({0, 0, 0}, 0), Room(2).From({0, 0, 0}, 0), Room(1).From({0.4, 0.1, 0}, 0.1),
      Room(1).From({0.4, 0.1, 0}, std::numbers::pi)};
  const std::vector<OrientationFrame> frames{FrameOf(0, 0), FrameOf(100, 0), FrameOf(200, 0.1),
                                             FrameOf(210, std::numbers::pi)};
  std::vector<LoopNode> nodes;
  for (size_t i = 0; i < frames.size(); ++i) nodes.push_back({{&features[i], &frames[i]}});
  ProgressReporter nobody;
  const auto loops = FindLoops(nodes, {}, {}, nobody);
  ASSERT_EQ(loops.size(), 1U);  // who comes back the other way has another orientation
  EXPECT_EQ(loops[0].a, frames[0].id);
  EXPECT_EQ(loops[0].b, frames[2].id);
  EXPECT_EQ(loops[0].kind, OrientationEdgeKind::kLoop);
  OrientationLoopOptions longer;
  longer.min_gap_frames = 300;
  EXPECT_TRUE(FindLoops(nodes, longer, {}, nobody).empty());
}

// A view whose lines gave a rotation, or didn't.
OrientationViewPtr ViewOf(const Room& room, const Eigen::Vector3d& place, double heading_rad,
                          double lines_heading_rad, bool reliable) {
  auto view = std::make_shared<OrientationView>();
  view->frame.rig_from_axes = Room::RotationAt(lines_heading_rad).conjugate().toRotationMatrix();
  view->frame.covariance = 1e-6 * Eigen::Matrix3d::Identity();
  view->frame.error = reliable ? FrameError::kNone : FrameError::kFewLines;
  view->features = room.From(place, heading_rad);
  return view;
}

double HeadingOf(const FollowedFrame& followed) {
  OrientationFrame frame;
  frame.rotation = followed.rotation;
  return HeadingOf(frame).value();
}

TEST(AxesFollower, FollowsTheHeadingThroughAWholeTurn) {
  const Room room(1);
  AxesFollower follower({}, {}, {});
  for (int i = 0; i < 70; ++i) {
    const double heading = 0.1 * i;
    // The lines know their axes modulo a quarter turn alone.
    const double lines = std::remainder(heading, std::numbers::pi / 2);
    const FollowedFrame f = follower.Follow(ViewOf(room, {0.01 * i, 0, 0}, heading, lines, true));
    EXPECT_TRUE(f.reliable);
    EXPECT_NEAR(std::remainder(HeadingOf(f) - heading, 2 * std::numbers::pi), 0, 1e-6);
  }
}

TEST(AxesFollower, FeaturesCarryItOverFramesWithoutLinesAndThroughSkewedRooms) {
  const Room room(1);
  for (const bool skewed : {false, true}) {
    AxesFollower follower({}, {}, {});
    follower.Follow(ViewOf(room, {0, 0, 0}, 0, 0, true));
    for (int i = 1; i <= 20; ++i) {  // turns by 1.2 rad where the lines lie
      const FollowedFrame f =
          follower.Follow(ViewOf(room, {0.02 * i, 0, 0}, 0.06 * i, 0.06 * i + 0.5, skewed));
      EXPECT_FALSE(f.reliable);
    }
    const double lines = 1.26 - std::numbers::pi / 2;
    const FollowedFrame f = follower.Follow(ViewOf(room, {0.42, 0, 0}, 1.26, lines, true));
    EXPECT_TRUE(f.reliable);
    EXPECT_NEAR(HeadingOf(f), 1.26, 1e-6);
  }
}

// A rig that is lost and comes back again and again.
TEST(AxesFollower, KeepsABoundedNumberOfViews) {
  const Room known(1);
  const Room other(2);
  AxesFollower follower({}, {}, {});
  std::vector<std::weak_ptr<const OrientationView>> views;
  const auto follow = [&](OrientationViewPtr view) {
    views.push_back(view);
    return follower.Follow(view);
  };
  for (int i = 0; i < 60; ++i) {
    EXPECT_TRUE(follow(ViewOf(known, {0, 0, 0}, 0, 0, true)).anchored) << i;
    for (int dark = 0; dark < 3; ++dark) {
      auto view = std::make_shared<OrientationView>();
      view->features.descriptors = Descriptors(DescriptorBytes(view->features.type));
      follow(view);
    }
    EXPECT_FALSE(follow(ViewOf(other, {0, 0, 0}, 0, 0.5, true)).anchored) << i;
  }
  const auto kept = std::ranges::count_if(views, [](const auto& view) { return !view.expired(); });
  EXPECT_LE(kept, 26);  // the first one, the last one and 24 anchors
}

}  // namespace
}  // namespace waystone
