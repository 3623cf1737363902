// SPDX-License-Identifier: Apache-2.0
#include "world/walk.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/base/error.h"
#include "tests/world/test_worlds.h"
#include "world/path.h"

namespace waystone {
namespace {

Eigen::Isometry3d Step(const Walk& walk, size_t i) {
  return walk.frames[i - 1].world_from_camera.inverse(Eigen::Isometry) *
         walk.frames[i].world_from_camera;
}

double AngleOf(const Eigen::Isometry3d& motion) {
  return Eigen::AngleAxisd(motion.rotation()).angle();
}

TEST(Walk, PosesFollowTheirAngles) {
  const double quarter = std::numbers::pi / 2.0;
  const auto forward = [](const Eigen::Isometry3d& pose) { return pose.linear().col(2).eval(); };
  const Eigen::Vector3d centre(1, 2, 3);
  EXPECT_TRUE(forward(WorldFromCamera(centre, 0.0)).isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(forward(WorldFromCamera(centre, quarter)).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_NEAR(forward(WorldFromCamera(centre, 0.0, 0.3)).z(), std::sin(0.3), 1e-12);
  EXPECT_TRUE(WorldFromCamera(centre, 0.5).translation().isApprox(centre));
  // Its top leans to its right: the camera's up axis, -y, gains a part of the right axis.
  const Eigen::Isometry3d leaning = WorldFromCamera(centre, 0.0, 0.0, 0.2);
  const Eigen::Vector3d level_right = WorldFromCamera(centre, 0.0).linear().col(0);
  EXPECT_GT((-leaning.linear().col(1)).dot(level_right), 0.1);
}

TEST(Walk, DemoToursAreSmoothFreeAndClosed) {
  const WalkOptions options;
  for (const FloorPlan& plan : {DemoPlan(), OtherPlan()}) {
    const Walk walk = DemoWalk(plan, options);
    EXPECT_GT(walk.frames.size(), 500U);
    for (size_t i = 0; i < walk.frames.size(); ++i) {
      const Eigen::Vector3d centre = walk.frames[i].world_from_camera.translation();
      EXPECT_TRUE(plan.IsFree(centre.head<2>(), 0.2)) << "frame " << i;
      EXPECT_NEAR(walk.frames[i].time_s, static_cast<double>(i) / options.frame_rate, 1e-9);
      if (i == 0) continue;
      EXPECT_LT(Step(walk, i).translation().norm(), options.step_m * 1.1);
      EXPECT_LT(AngleOf(Step(walk, i)), options.turn_rad * 1.2);
    }
    const Eigen::Vector3d home = walk.frames.front().world_from_camera.translation() -
                                 walk.frames.back().world_from_camera.translation();
    EXPECT_LT(home.head<2>().norm(), 0.1);
    for (const Eigen::Vector2i& stop : plan.stops) {
      double nearest = 1e9;
      for (const WalkFrame& frame : walk.frames) {
        const Eigen::Vector2d at = frame.world_from_camera.translation().head<2>();
        nearest = std::min(nearest, (at - plan.CentreOf(stop)).norm());
      }
      EXPECT_LT(nearest, 1.0) << "every stop is visited";
    }
  }
}

TEST(Walk, DemoToursHaveParallaxMostOfTheTime) {
  const Walk walk = DemoWalk(DemoPlan());
  size_t moving = 0;
  for (size_t i = 1; i < walk.frames.size(); ++i) {
    moving += Step(walk, i).translation().norm() > 0.2 * WalkOptions().step_m;
  }
  EXPECT_GT(moving, walk.frames.size() * 9 / 10);
}

TEST(Walk, GoesThroughWaypointsOfThePlan) {
  const FloorPlan plan = TwoRooms();
  WalkOptions options;
  options.sway = 0.0;
  options.gaze_rad = 0.0;
  const Walk walk = WalkThrough(plan, {{2.0, 4.0}, {13.0, 4.0}}, options);
  const Eigen::Isometry3d& first = walk.frames.front().world_from_camera;
  EXPECT_TRUE(first.translation().isApprox(Eigen::Vector3d(1.0, 2.0, options.height_m)));
  EXPECT_TRUE(first.linear().col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-9));
  EXPECT_NEAR(walk.frames.back().world_from_camera.translation().x(), 6.5, options.step_m);
  EXPECT_NEAR(static_cast<double>(walk.frames.size()), 5.5 / options.step_m, 2.0);
}

TEST(Walk, CanTurnOnTheSpot) {
  const FloorPlan plan = TwoRooms();
  WalkOptions options;
  options.turn_on_spot_rad = 1.0;
  const Walk walk = WalkThrough(plan, {{2.0, 4.0}, {13.0, 4.0}}, options);
  size_t turning = 0;
  double angle = 0.0;
  for (size_t i = 1; i < walk.frames.size(); ++i) {
    if (Step(walk, i).translation().norm() > 1e-9) continue;
    ++turning;
    angle += AngleOf(Step(walk, i));
  }
  EXPECT_NEAR(angle, 2.0, 0.2) << "there and back";
  EXPECT_GT(turning, 30U);
  const Walk plain = WalkThrough(plan, {{2.0, 4.0}, {13.0, 4.0}});
  for (size_t i = 1; i < plain.frames.size(); ++i) {
    EXPECT_GT(Step(plain, i).translation().norm(), 1e-3);
  }
}

TEST(Walk, SeedChangesTheHandAlone) {
  WalkOptions other;
  other.seed = 2;
  const Walk a = DemoWalk(TwoRooms());
  const Walk b = DemoWalk(TwoRooms(), other);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  const Eigen::Vector3d difference =
      a.frames[40].world_from_camera.translation() - b.frames[40].world_from_camera.translation();
  EXPECT_LT(difference.head<2>().norm(), 1e-12);
  EXPECT_GT(std::abs(difference.z()), 1e-6);
}

TEST(Walk, RefusesWaysThroughWallsAndBadOptions) {
  const FloorPlan plan = TwoRooms();
  EXPECT_THROW(WalkThrough(plan, {{2.0, 2.0}, {13.0, 2.0}}), MapError);
  EXPECT_THROW(WalkThrough(plan, {{2.0, 2.0}, {40.0, 2.0}}), MapError);
  EXPECT_THROW(WalkThrough(plan, {{2.0, 2.0}}), MapError);
  EXPECT_THROW(WalkThrough(plan, {{2.0, 4.0}, {3.0, 4.0}}, {.height_m = 2.1}), MapError);
  EXPECT_THROW(WalkThrough(plan, {{2.0, 4.0}, {3.0, 4.0}}, {.step_m = 0.0}), MapError);
  EXPECT_THROW(DemoWalk(ParseFloorPlan("####\n#1.#\n####\n")), MapError);
  EXPECT_THROW(DemoWalk(ParseFloorPlan("#####\n#1#2#\n#####\n")), MapError);
}

TEST(Path, TakesTheShortestWayAroundWalls) {
  const FloorPlan plan = TwoRooms();
  const auto path = FindPath(plan, {3, 3}, {11, 3});
  EXPECT_EQ(path.front(), Eigen::Vector2i(3, 3));
  EXPECT_EQ(path.back(), Eigen::Vector2i(11, 3));
  EXPECT_LE(path.size(), 11U);
  for (size_t i = 1; i < path.size(); ++i) {
    EXPECT_TRUE(plan.IsOpen(path[i].x(), path[i].y()));
    EXPECT_LE((path[i] - path[i - 1]).cwiseAbs().maxCoeff(), 1);
  }
  EXPECT_THROW(FindPath(plan, {0, 0}, {11, 3}), MapError);
}

}  // namespace
}  // namespace waystone
