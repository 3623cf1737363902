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

// What the same views look like through another camera in place of the made one; what it can't see
// is left out.
MatchedPoints Through(const Camera& camera, const MatchedPoints& seen) {
  MatchedPoints points;
  for (int i = 0; i < seen.size(); ++i) {
    const auto from = Project(camera, Unproject(MadeCamera(), seen.from[i]));
    const auto to = Project(camera, Unproject(MadeCamera(), seen.to[i]));
    if (!from || !to) continue;
    points.from.push_back(*from);
    points.to.push_back(*to);
  }
  return points;
}

std::vector<Camera> CamerasOfEveryModel() {
  return {{CameraModel::kSimplePinhole, 640, 480, {500, 300, 250}},
          {CameraModel::kPinhole, 640, 480, {420, 560, 330, 230}},
          {CameraModel::kSimpleRadial, 640, 480, {500, 319.5, 239.5, -0.25}},
          {CameraModel::kRadial, 640, 480, {480, 310, 245, -0.3, 0.1}},
          {CameraModel::kOpenCv, 640, 480, {500, 505, 315, 235, -0.28, 0.07, 1e-3, -5e-4}},
          {CameraModel::kFullOpenCv,
           640,
           480,
           {500, 500, 319.5, 239.5, -0.3, 0.09, 0, 0, 0.01, 0.02, 0, 0}},
          {CameraModel::kOpenCvFisheye, 640, 480, {400, 400, 319.5, 239.5, 0.02, -0.01, 0, 0}},
          {CameraModel::kEquirectangular, 2400, 1200, {}}};
}

TEST(RotatesOnly, TakesTheDistortionOfEveryModelOut) {
  for (const Camera& camera : CamerasOfEveryModel()) {
    for (uint64_t seed = 1; seed <= 3; ++seed) {
      MadeScene scene = Corner(seed);
      const MatchedPoints turn =
          Through(camera, MatchesOf(scene, PoseAt(0, 0, 0), PoseAt(0, 0, 0, 0.2)));
      ASSERT_GT(turn.size(), 60) << NameOf(camera.model);
      EXPECT_TRUE(Rotates(turn, camera)) << NameOf(camera.model) << ", seed " << seed;
      MadeScene wall = OneWall(seed);
      const MatchedPoints step =
          Through(camera, MatchesOf(wall, PoseAt(0, 0, 0), PoseAt(0.3, 0.1, 0.2, 0.1)));
      EXPECT_FALSE(Rotates(step, camera)) << NameOf(camera.model) << ", seed " << seed;
    }
  }
}

TEST(RotatesOnly, NeedsTheDistortionOfAStrongLens) {
  MadeScene scene = Corner(9);
  const Camera lens{CameraModel::kSimpleRadial, 640, 480, {500, 319.5, 239.5, -0.25}};
  const MatchedPoints turn = Through(lens, MatchesOf(scene, PoseAt(0, 0, 0), PoseAt(0, 0, 0, 0.2)));
  EXPECT_TRUE(Rotates(turn, lens));
  EXPECT_FALSE(Rotates(turn, MadeCamera())) << "a lens that changes nothing shows nothing";
}

// A panorama sees all around; only what lies ahead can be made straight.
TEST(RotatesOnly, LeavesOutWhatLiesBehind) {
  const Camera panorama{CameraModel::kEquirectangular, 2400, 1200, {}};
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Random random(10);
  MatchedPoints all;
  MatchedPoints behind;
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector3d ray =
        Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
    const Eigen::Vector2d noise(0.2 * random.Normal(), 0.2 * random.Normal());
    for (MatchedPoints* points : {&all, &behind}) {
      if (points == &behind && ray.z() > -0.2) continue;
      points->from.push_back(*Project(panorama, ray));
      points->to.emplace_back(*Project(panorama, turn * ray) + noise);
    }
  }
  EXPECT_TRUE(RotatesOnly(all, 2400, 1200, panorama, {}, {}, 1));
  EXPECT_FALSE(RotatesOnly(behind, 2400, 1200, panorama, {}, {}, 1));
}

TEST(RotatesOnly, IsFalseForFewMatches) {
  MadeScene scene = Corner(8);
  const MatchedPoints all = MatchesOf(scene, PoseAt(0, 0, 0), PoseAt(0, 0, 0, 0.1));
  for (int count = 0; count < 4; ++count) {
    MatchedPoints few;
    few.from.assign(all.from.begin(), all.from.begin() + count);
    few.to.assign(all.to.begin(), all.to.begin() + count);
    EXPECT_FALSE(Rotates(few, std::nullopt)) << count;
    EXPECT_FALSE(Rotates(few, MadeCamera())) << count;
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
  expect_refused([](auto& o) { o.max_angle_rad = 0; });
  expect_refused([](auto& o) { o.max_angle_rad = 1.6; });
  EXPECT_NO_THROW(RotationOptions{}.Check());
}

// Rounding, which is all that two copies of an image differ by, decides nothing.
TEST(RotatesOnly, IsTrueForTheSameImageTwice) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    MadeScene scene = Corner(seed);
    MatchedPoints points = MatchesOf(scene, PoseAt(0, 0, 0), PoseAt(0, 0, 0));
    points.to = points.from;
    EXPECT_TRUE(Rotates(points, MadeCamera())) << "seed " << seed;
    EXPECT_TRUE(Rotates(points, std::nullopt)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace waystone
