// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/align_frames.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/geometry/rotation.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Vector3d RandomVector(Random& random, double size) {
  return size * Vector3d(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1));
}

Isometry3d RandomPose(Random& random) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = RotationByVector(RandomVector(random, 1));
  pose.translation() = RandomVector(random, 5);
  return pose;
}

FrameChange RandomChange(Random& random, double scale) {
  return {scale, RotationByVector(RandomVector(random, 2)), RandomVector(random, 20), 0};
}

Isometry3d Moved(const FrameChange& change, Isometry3d pose) {
  pose.linear() = change.rotation * pose.linear();
  pose.translation() = change.scale * change.rotation * pose.translation() + change.translation;
  return pose;
}

// The poses of `to` have errors of one centimetre and a tenth of a degree.
std::vector<CameraInFrames> Cameras(Random& random, const FrameChange& change, int count) {
  std::vector<CameraInFrames> cameras;
  for (int i = 0; i < count; ++i) {
    const Isometry3d from = RandomPose(random);
    Isometry3d to = Moved(change, from);
    to.translation() += RandomVector(random, 0.01);
    to.linear() = RotationByVector(RandomVector(random, 0.002)) * to.linear();
    cameras.push_back({to, from, 0.01});
  }
  return cameras;
}

void ExpectChange(const std::optional<FrameChange>& found, const FrameChange& truth) {
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->scale / truth.scale, 1, 0.005);
  EXPECT_LT(RotationAngle(found->rotation, truth.rotation), 0.002);
  const Vector3d at(1, -2, 3);
  EXPECT_LT((found->scale * found->rotation * at + found->translation -
             (truth.scale * truth.rotation * at + truth.translation))
                .norm(),
            0.02);
}

TEST(AlignFrames, FindsRotationScaleAndTranslation) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const FrameChange truth = RandomChange(random, random.Uniform(0.2, 5));
    ExpectChange(AlignFrames(Cameras(random, truth, 12), false), truth);
  }
}

TEST(AlignFrames, LeavesOutWhatDisagrees) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const FrameChange truth = RandomChange(random, 1);
    std::vector<CameraInFrames> cameras = Cameras(random, truth, 100);
    for (int i = 0; i < 40; ++i) cameras[2 * i].to_from_camera = RandomPose(random);
    const auto found = AlignFrames(cameras, seed % 2 == 0);
    ExpectChange(found, truth);
    EXPECT_GE(found->cameras, 40);
  }
}

TEST(AlignFrames, FindsNothingWhereTooFewAgree) {
  Random random(3);
  const FrameChange truth = RandomChange(random, 1);
  EXPECT_FALSE(AlignFrames(Cameras(random, truth, 2), true));
  std::vector<CameraInFrames> cameras = Cameras(random, truth, 12);
  for (int i = 0; i < 8; ++i) cameras[i].to_from_camera = RandomPose(random);
  EXPECT_FALSE(AlignFrames(cameras, true));
}

TEST(AlignFrames, CamerasAtOnePlaceGiveNoScale) {
  Random random(4);
  const FrameChange truth = RandomChange(random, 2);
  std::vector<CameraInFrames> cameras = Cameras(random, truth, 6);
  for (CameraInFrames& camera : cameras) {
    camera.from_from_camera.translation() = Vector3d(1, 2, 3) + RandomVector(random, 1e-3);
    camera.to_from_camera.translation() =
        Moved(truth, camera.from_from_camera).translation() + RandomVector(random, 0.005);
  }
  EXPECT_FALSE(AlignFrames(cameras, false));
  EXPECT_TRUE(AlignFrames(cameras, true));
}

// What a camera sees stays where it is: on its plane, at its pixel's depth.
TEST(ChangeFrame, MovesPosesPlanesAndDepthsTogether) {
  Random random(5);
  const FrameChange change = RandomChange(random, 3);
  const Isometry3d camera = RandomPose(random);
  const Vector3d ray = RandomVector(random, 1).normalized();
  const double depth = 2.5;
  PoseLayer layer;
  layer.frame = "map";
  layer.noise.position_sigma = 0.02;
  layer.keyframes.push_back(MakeKeyframePose({1}, camera));
  PlanePose plane;
  plane.plane = {1};
  plane.normal = RandomVector(random, 1).normalized();
  plane.distance = plane.normal.dot(camera * (depth * ray));
  plane.covariance = Eigen::Vector4d(1e-4, 2e-4, 3e-4, 1e-3).asDiagonal();
  layer.planes.push_back(plane);
  layer.plane_depths.push_back({{1}, {EncodeDepth(depth, 0.01), DepthCode{}}});
  layer.landmark_depths.push_back({{1}, {EncodeDepth(depth, 0.02)}});
  ChangeFrame(change, layer);
  const Isometry3d moved = layer.keyframes[0].frame_from_camera();
  EXPECT_TRUE(moved.isApprox(Moved(change, camera), 1e-9));
  EXPECT_NEAR(DepthOf(layer.plane_depths[0].features[0]), 3 * depth, 3 * depth * 1e-3);
  EXPECT_NEAR(RelativeSigmaOf(layer.plane_depths[0].features[0]), 0.01, 1e-4);
  EXPECT_FALSE(layer.plane_depths[0].features[1].known());
  EXPECT_NEAR(DepthOf(layer.landmark_depths[0].landmarks[0]), 3 * depth, 3 * depth * 1e-3);
  EXPECT_NEAR(layer.planes[0].normal.dot(moved * (3 * depth * ray)), layer.planes[0].distance,
              1e-9);
  EXPECT_DOUBLE_EQ(layer.noise.position_sigma, 0.06);
  // The distance of the moved camera from the plane is as uncertain as before, times the scale.
  const auto variance = [](const PlanePose& one, const Vector3d& x) {
    const Eigen::Vector4d by_plane(x.x(), x.y(), x.z(), -1);
    return by_plane.dot(one.covariance * by_plane);
  };
  EXPECT_NEAR(variance(layer.planes[0], moved.translation()),
              9 * variance(plane, camera.translation()), 1e-9);
}

}  // namespace
}  // namespace waystone
