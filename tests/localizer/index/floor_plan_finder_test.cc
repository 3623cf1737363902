// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/floor_plan_finder.h"

#include <gtest/gtest.h>

#include <string>

namespace waystone {
namespace {

// 10 px a unit, the lower left corner of the image at (0, 0).
FloorPlanImage MakePlan(const std::string& name, int width, int height,
                        std::optional<PlanHeights> heights = std::nullopt) {
  FloorPlanImage plan;
  plan.name = name;
  plan.width = width;
  plan.height = height;
  plan.anchors = {{{0, double(height)}, {0, 0}},
                  {{double(width), double(height)}, {width / 10., 0}}};
  plan.heights = heights;
  return plan;
}

// `up` is an axis of the frame; keyframes are upright.
MapData PosedMap(const Eigen::Vector3d& up) {
  MapData map;
  map.poses.emplace();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d ahead = up.unitOrthogonal();
  pose.linear() << ahead.cross(up), -up, ahead;
  map.poses->keyframes.push_back(MakeKeyframePose({1}, pose));
  return map;
}

std::string NameAt(const FloorPlanFinder& plans, const Eigen::Vector3d& position) {
  const auto found = plans.Find(position);
  return found ? found->name : "";
}

TEST(FloorPlanFinder, GivesPixels) {
  MapData map = PosedMap(Eigen::Vector3d::UnitZ());
  map.floor_plans = {MakePlan("Ground", 200, 100)};
  const FloorPlanFinder plans(map);
  const auto found = plans.Find(Eigen::Vector3d(5, 2, 77));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->name, "Ground");
  EXPECT_LT((found->px - Eigen::Vector2d(50, 80)).norm(), 1e-9);
  EXPECT_TRUE(plans.Find(Eigen::Vector3d(20, 10, 0)));  // a corner
  for (const Eigen::Vector3d& beside : {Eigen::Vector3d(-0.1, 2, 0), Eigen::Vector3d(20.1, 2, 0),
                                        Eigen::Vector3d(5, -0.1, 0), Eigen::Vector3d(5, 10.1, 0)}) {
    EXPECT_FALSE(plans.Find(beside)) << beside.transpose();
  }
  EXPECT_FALSE(plans.Find(Pose2{5, 2, 0})) << "panoramas are in another frame";
}

// In a frame with y down the picture from above has x to the right and z to the top.
TEST(FloorPlanFinder, LooksFromAbove) {
  MapData map = PosedMap(-Eigen::Vector3d::UnitY());
  map.floor_plans = {MakePlan("Ground", 200, 100, PlanHeights{1, 2})};
  const FloorPlanFinder plans(map);
  const auto found = plans.Find(Eigen::Vector3d(5, -1.5, 2));
  ASSERT_TRUE(found);
  EXPECT_LT((found->px - Eigen::Vector2d(50, 80)).norm(), 1e-9);
  EXPECT_FALSE(plans.Find(Eigen::Vector3d(5, 1.5, 2)));
}

TEST(FloorPlanFinder, TellsStoreysApart) {
  MapData map = PosedMap(Eigen::Vector3d::UnitZ());
  map.floor_plans = {MakePlan("All", 400, 400), MakePlan("Attic", 200, 100, PlanHeights{5.5, 8}),
                     MakePlan("Ground", 200, 100, PlanHeights{-1, 2.8}),
                     MakePlan("Upper", 200, 100, PlanHeights{2.8, 5.6})};
  const FloorPlanFinder plans(map);
  EXPECT_EQ(NameAt(plans, {5, 2, 1.5}), "Ground");
  EXPECT_EQ(NameAt(plans, {5, 2, 4.5}), "Upper");
  EXPECT_EQ(NameAt(plans, {5, 2, 5.55}), "Attic") << "the narrowest range counts";
  EXPECT_EQ(NameAt(plans, {5, 2, 9}), "All");
  EXPECT_EQ(NameAt(plans, {30, 2, 1.5}), "All") << "beside the image of the storey";
  EXPECT_EQ(NameAt(plans, {50, 2, 1.5}), "");
}

TEST(FloorPlanFinder, TakesPanoramasOfMapsWithoutPoses) {
  MapData map;
  map.appearance.emplace();
  map.floor_plans = {MakePlan("Ground", 200, 100)};
  const FloorPlanFinder plans(map);
  const auto found = plans.Find(Pose2{5, 2, 1});
  ASSERT_TRUE(found);
  EXPECT_LT((found->px - Eigen::Vector2d(50, 80)).norm(), 1e-9);
  EXPECT_FALSE(plans.Find(Eigen::Vector3d(5, 2, 0)));
  EXPECT_FALSE(FloorPlanFinder(MapData{}).Find(Pose2{0, 0, 0}));
}

}  // namespace
}  // namespace waystone
