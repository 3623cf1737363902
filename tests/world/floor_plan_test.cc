// SPDX-License-Identifier: Apache-2.0
#include "world/floor_plan.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace waystone {
namespace {

// What ParseFloorPlan says about a bad plan.
std::string MessageOf(const std::string& text, const PlanOptions& size = {}) {
  try {
    ParseFloorPlan(text, size);
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    return error.what();
  }
  ADD_FAILURE() << "accepted:\n" << text;
  return "";
}

bool Says(const std::string& message, const std::string& part) {
  return message.find(part) != std::string::npos;
}

TEST(FloorPlan, ReadsCellsPostersDoorsAndStops) {
  const FloorPlan plan = ParseFloorPlan("\r\n#####\r\n#2D1#\r\n#.  a\r\n####\r\n\r\n");
  EXPECT_EQ(plan.columns, 5);
  EXPECT_EQ(plan.rows, 4);
  EXPECT_TRUE(plan.IsOpen(1, 1));
  EXPECT_TRUE(plan.IsOpen(2, 2));
  EXPECT_TRUE(plan.IsDoor(2, 1));
  EXPECT_FALSE(plan.IsDoor(1, 1));
  EXPECT_EQ(plan.PosterAt(4, 2), 'a');
  EXPECT_EQ(plan.PosterAt(0, 0), 0);
  EXPECT_FALSE(plan.IsOpen(4, 3)) << "short lines are filled up with wall";
  EXPECT_FALSE(plan.IsOpen(-1, 1));
  EXPECT_FALSE(plan.IsOpen(1, 4));
  ASSERT_EQ(plan.stops.size(), 2U);
  EXPECT_EQ(plan.stops[0], Eigen::Vector2i(3, 1));
  EXPECT_EQ(plan.stops[1], Eigen::Vector2i(1, 1));
}

TEST(FloorPlan, PutsTheOriginAtTheSouthWestCorner) {
  const FloorPlan plan = ParseFloorPlan("####\n#..#\n#..#\n####\n", {.cell_m = 2.0});
  EXPECT_TRUE(plan.CentreOf({1, 2}).isApprox(Eigen::Vector2d(3.0, 3.0)));
  EXPECT_TRUE(plan.CentreOf({1, 1}).isApprox(Eigen::Vector2d(3.0, 5.0)));
  EXPECT_TRUE(plan.IsFree({4.0, 4.0}, 1.9));
  EXPECT_FALSE(plan.IsFree({4.0, 4.0}, 2.1));
  EXPECT_FALSE(plan.IsFree({-3.0, 4.0}, 0.0));
}

TEST(FloorPlan, TextReadsBackAsTheSamePlan) {
  const FloorPlan plan = ParseFloorPlan("\n\n#####\n#1.2#\n###\n");
  const FloorPlan again = ParseFloorPlan(plan.Text());
  EXPECT_EQ(again.lines, plan.lines);
  EXPECT_EQ(again.stops, plan.stops);
}

TEST(FloorPlan, NamesLineAndColumnOfWhatIsWrong) {
  EXPECT_TRUE(Says(MessageOf("###\n#?#\n###\n"), "line 2, column 2"));
  EXPECT_TRUE(Says(MessageOf("###\n#\t#\n###\n"), "code 9"));
  EXPECT_TRUE(Says(MessageOf("###\n..#\n###\n"), "line 2, column 1"));
  EXPECT_TRUE(Says(MessageOf("\n#.#\n#.#\n###\n"), "line 2, column 2"));
  EXPECT_TRUE(Says(MessageOf("####\n#11#\n####\n"), "line 2, column 3"));
  EXPECT_TRUE(Says(MessageOf("####\n#.3#\n####\n"), "stop 3 but no stop 1"));
  EXPECT_TRUE(Says(MessageOf(""), "empty"));
  EXPECT_TRUE(Says(MessageOf(" \n  \n"), "empty"));
  EXPECT_TRUE(Says(MessageOf("###\n###\n###\n"), "no floor"));
  EXPECT_TRUE(Says(MessageOf(std::string(1001, '#')), "1000"));
}

TEST(FloorPlan, RefusesSizesOutOfRange) {
  const std::string room = "###\n#.#\n###\n";
  EXPECT_TRUE(Says(MessageOf(room, {.cell_m = 0.0}), "cell_m"));
  EXPECT_TRUE(Says(MessageOf(room, {.wall_height_m = std::nan("")}), "wall_height_m"));
  EXPECT_TRUE(Says(MessageOf(room, {.wall_height_m = 2.0, .door_height_m = 2.1}), "door_height_m"));
}

}  // namespace
}  // namespace waystone
