// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/rotation_only.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/builder/planes/made_scene.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;

// Matches between two views of all that a scene shows; every descriptor is unique.
MatchedPoints MatchesOf(MadeScene& scene, const Isometry3d& a, const Isometry3d& b,
                        double sigma_px = 0.3) {
  const Features from = scene.See(a, sigma_px);
  const Features to = scene.See(b, sigma_px);
  MatchedPoints points;
  for (int i = 0; i < from.size(); ++i) {
    for (int j = 0; j < to.size(); ++j) {
      if (scene.PointOf(from.descriptors.row(i)) != scene.PointOf(to.descriptors.row(j))) continue;
      points.from.emplace_back(from.keypoints[i].x_px, from.keypoints[i].y_px);
      points.to.emplace_back(to.keypoints[j].x_px, to.keypoints[j].y_px);
    }
  }
  return points;
}

bool Rotates(const MatchedPoints& points, const std::optional<Camera>& camera) {
  return RotatesOnly(points, 640, 480, camera, {}, {}, 1);
}

MadeScene Corner(uint64_t seed) {
  MadeScene scene(seed);
  scene.AddWall({{-4, -3, 2.8}, {4, 0, 3.2}, {0, 6, 0}}, 120);
  scene.AddWall({{0, -3, 6}, {4, 0, -3.2}, {0, 6, 0}}, 120);
  return scene;
}

// One wall that fills the view, seen under an angle.
MadeScene OneWall(uint64_t seed) {
  MadeScene scene(seed);
  scene.AddWall({{-6, -4, 3}, {12, 0, 3}, {0, 8, 0.5}}, 300);
  return scene;
}

TEST(RotatesOnly, IsTrueForATurnWithAndWithoutACamera) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    MadeScene scene = Corner(seed);
    for (double yaw : {0.03, 0.1, 0.2}) {
      const MatchedPoints points = MatchesOf(scene, PoseAt(0, 0, 0), PoseAt(0, 0, 0, yaw));
      EXPECT_TRUE(Rotates(points, MadeCamera())) << "yaw " << yaw << ", seed " << seed;
      // The wider the turn, the finer the focal length has to be searched.
      RotationOptions fine;
      fine.focal_steps = 60;
      EXPECT_TRUE(RotatesOnly(points, 640, 480, std::nullopt, fine, {}, 1))
          << "yaw " << yaw << ", seed " << seed;
      if (yaw < 0.05) {
        EXPECT_TRUE(Rotates(points, std::nullopt)) << "yaw " << yaw << ", seed " << seed;
      }
    }
  }
}

TEST(RotatesOnly, IsTrueForATurnWithSomeWrongMatches) {
  MadeScene scene = Corner(6);
  MatchedPoints points = MatchesOf(scene, PoseAt(0, 0, 0), PoseAt(0, 0, 0, 0.03));
  for (int i = 0; i < points.size(); i += 20) {
    points.to[i] = {scene.random().Uniform(0, 640), scene.random().Uniform(0, 480)};
  }
  EXPECT_TRUE(Rotates(points, MadeCamera()));
  EXPECT_TRUE(Rotates(points, std::nullopt));
}

TEST(RotatesOnly, IsFalseForASinglePlaneThatFillsTheView) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    MadeScene scene = OneWall(seed);
    for (const Isometry3d& moved :
         {PoseAt(0.4, 0, 0), PoseAt(0, 0, 0.5), PoseAt(0.3, 0.1, 0.2, 0.1)}) {
      const MatchedPoints points = MatchesOf(scene, PoseAt(0, 0, 0), moved);
      ASSERT_GT(points.size(), 60);
      EXPECT_FALSE(Rotates(points, MadeCamera())) << "seed " << seed;
      EXPECT_FALSE(Rotates(points, std::nullopt)) << "seed " << seed;
    }
  }
}

TEST(RotatesOnly, IsFalseForTwoWallsAndAStep) {
  MadeScene scene = Corner(7);
  const MatchedPoints points = MatchesOf(scene, PoseAt(0, 0, 0), PoseAt(0.4, 0, 0, 0.05));
  EXPECT_FALSE(Rotates(points, MadeCamera()));
  EXPECT_FALSE(Rotates(points, std::nullopt));
}

TEST(RotatesOnly, IsFalseForFewMatches) {
  MadeScene scene = Corner(8);
  const MatchedPoints all = MatchesOf(scene, PoseAt(0, 0, 0), PoseAt(0, 0, 0, 0.1));
  for (int count = 0; count < 4; ++count) {
    MatchedPoints few;
    few.from.assign(all.from.begin(), all.from.begin() + count);
    few.to.assign(all.to.begin(), all.to.begin() + count);
    EXPECT_FALSE(Rotates(few, std::nullopt)) << count;
  }
}

TEST(RotationOptions, OutOfTheirRangeAreRefused) {
  const auto expect_refused = [](auto change) {
    RotationOptions options;
    change(options);
    EXPECT_THROW(options.Check(), MapError);
  };
  expect_refused([](auto& o) { o.min_share = 0; });
  expect_refused([](auto& o) { o.max_excess = 0.9; });
  expect_refused([](auto& o) { o.min_focal = 0; });
  expect_refused([](auto& o) { o.max_focal = o.min_focal; });
  expect_refused([](auto& o) { o.focal_steps = 1; });
  EXPECT_NO_THROW(RotationOptions{}.Check());
}

}  // namespace
}  // namespace waystone
