// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

PosedCamera CameraAt(const Vector3d& centre, double yaw_rad) {
  PosedCamera camera;
  camera.k << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  camera.centre = centre;
  camera.world_from_camera = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitY()).toRotationMatrix();
  return camera;
}

Vector2d Project(const PosedCamera& camera, const Vector3d& x) {
  return (camera.k * (camera.world_from_camera.transpose() * (x - camera.centre))).hnormalized();
}

// Twenty points in front of both cameras, as each sees them.
struct Views {
  PosedCamera a = CameraAt({0, 0, 0}, 0.1);
  PosedCamera b = CameraAt({1.5, 0.2, -0.4}, -0.2);
  std::vector<Vector2d> in_a;
  std::vector<Vector2d> in_b;

  Views() {
    Random random(3);
    for (int i = 0; i < 20; ++i) {
      const Vector3d x(random.Uniform(-1, 2), random.Uniform(-1, 1), random.Uniform(4, 8));
      in_a.push_back(Project(a, x));
      in_b.push_back(Project(b, x));
    }
  }
};

TEST(EpipolarError, IsNoneForTheSamePoints) {
  const Views views;
  EXPECT_LT(MedianEpipolarError(views.a, views.b, views.in_a, views.in_b), 1e-6);
}

TEST(EpipolarError, IsTheDistanceToTheLine) {
  Views views;
  // The baseline is nearly horizontal, and so are the lines.
  for (Vector2d& x : views.in_b) x.y() += 10;
  const double error = MedianEpipolarError(views.a, views.b, views.in_a, views.in_b);
  EXPECT_GT(error, 8);
  EXPECT_LT(error, 10.1);
}

TEST(EpipolarError, OtherPointsAreOff) {
  Views views;
  std::rotate(views.in_b.begin(), views.in_b.begin() + 7, views.in_b.end());
  EXPECT_GT(MedianEpipolarError(views.a, views.b, views.in_a, views.in_b), 10);
}

TEST(EpipolarError, PointsBehindACameraAreNotSeenByBoth) {
  Views views;
  views.b.world_from_camera =
      views.b.world_from_camera * Eigen::AngleAxisd(M_PI, Vector3d::UnitY()).toRotationMatrix();
  for (size_t i = 0; i < views.in_b.size(); ++i) views.in_b[i].x() = 640 - views.in_b[i].x();
  EXPECT_TRUE(std::isinf(MedianEpipolarError(views.a, views.b, views.in_a, views.in_b)));
  EXPECT_TRUE(std::isinf(MedianEpipolarError(views.a, views.b, {}, {})));
}

TEST(WorldScene, JudgesByTheRenderedPlanes) {
  const auto scene = MakeWorldScene(20, 1, {});
  EXPECT_EQ(scene->queries(), 1);
  EXPECT_EQ(scene->Decode(0).cols, 640);
  SceneAnswer answer;
  answer.image_frame = answer.reference_frame = 0;
  for (int i = 0; i < 10; ++i) answer.query_points.emplace_back(300 + 4 * i, 200 + 3 * i);
  for (const Eigen::Vector2d& x : answer.query_points) {
    answer.reference_points.emplace_back(x.x() + 400, x.y());  // far off
  }
  EXPECT_FALSE(scene->IsRight(0, answer));
  answer.query_points.resize(2);  // too few to tell
  answer.reference_points.resize(2);
  EXPECT_FALSE(scene->IsRight(0, answer));
}

// A place without planes is judged by its keyframe's matches.
TEST(SceneAnswerOf, TakesTheMatchesOfAPlaceWithoutPlanes) {
  MapData map;
  map.sequences.push_back({SequenceId{1}, "walk", "folder", 9, 0, {}});
  map.keyframes.push_back({KeyframeId{4}, SequenceId{1}, 0, 7, "7.jpg", {}, 640, 480, {}, {}});
  Answer answer;
  answer.verdict = Verdict::kLocalized;
  answer.planes.keyframe = KeyframeRef{KeyframeId{4}, "walk", "7.jpg", {}};
  answer.planes.epipolar = EpipolarMatches{*answer.planes.keyframe, 1, 1, {{10, 20}}, {{30, 40}}};
  const SceneAnswer place = SceneAnswerOf(*MapIndex::Build(std::move(map)), answer);
  EXPECT_EQ(place.image_frame, 7);
  EXPECT_EQ(place.reference_frame, 7);
  ASSERT_EQ(place.query_points.size(), 1u);
  EXPECT_EQ(place.query_points[0], Eigen::Vector2d(10, 20));
  EXPECT_EQ(place.reference_points.at(0), Eigen::Vector2d(30, 40));
}

TEST(ReadPhotoPoses, TakesWholeLinesOnly) {
  const ScratchFolder folder;
  const auto write = [&](const std::string& line) {
    std::ofstream(folder.path() / "poses.csv") << "role,image,...\n" << line << "\n";
  };
  write("map,a.jpg,500,501,320,240,1,2,3,1,0,0,0,0,-1,0,1,0");
  const std::vector<PhotoPose> photos = ReadPhotoPoses(folder.path());
  ASSERT_EQ(photos.size(), 1U);
  EXPECT_EQ(photos[0].role, "map");
  EXPECT_EQ(photos[0].image, "a.jpg");
  EXPECT_EQ(photos[0].camera.k(1, 1), 501);
  EXPECT_EQ(photos[0].camera.k(0, 2), 320);
  EXPECT_EQ(photos[0].camera.centre, Vector3d(1, 2, 3));
  EXPECT_EQ(photos[0].camera.world_from_camera.col(2), Vector3d(0, -1, 0));
  write("map,a.jpg,500,501,320,240,1,2,3");
  EXPECT_THROW(ReadPhotoPoses(folder.path()), MapError);
}

}  // namespace
}  // namespace waystone::bench
