// SPDX-License-Identifier: Apache-2.0
#include "world/flat.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "world/walk.h"

namespace waystone {
namespace {

Flat FlatOf(uint64_t seed) {
  FlatOptions options;
  options.seed = seed;
  return MakeFlat(options);
}

bool IsSame(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0; }

cv::Mat Picture(const Flat& flat, const SceneLighting& lighting, const Eigen::Vector3d& at) {
  FlatCamera camera;
  camera.width_px = 128;
  camera.noise_sigma = 0;
  return RenderFlat(flat, lighting, WorldFromCamera(at, 0.3), camera);
}

TEST(FlatTest, IsAFunctionOfItsSeed) {
  FlatTourOptions tour;
  tour.per_room = 1;
  tour.camera.width_px = 64;
  const auto first = PhotographFlat(FlatOf(3), tour);
  const auto again = PhotographFlat(FlatOf(3), tour);
  const auto other = PhotographFlat(FlatOf(4), tour);
  ASSERT_EQ(first.size(), again.size());
  for (size_t i = 0; i < first.size(); ++i) EXPECT_TRUE(IsSame(first[i].grey, again[i].grey)) << i;
  EXPECT_FALSE(IsSame(first[0].grey, other[0].grey));
}

TEST(FlatTest, RoomsAreSmallAndJoinedByDoors) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Flat flat = FlatOf(seed);
    ASSERT_EQ(flat.scene.rooms.size(), size_t{6});
    std::vector<int> group = {0, 1, 2, 3, 4, 5};
    for (const FlatDoor& door : flat.doors) {
      const int from = group[door.rooms[0]];
      std::ranges::replace(group, from, group[door.rooms[1]]);
    }
    for (size_t i = 0; i < flat.scene.rooms.size(); ++i) {
      const Eigen::Vector2d side = flat.scene.rooms[i].high - flat.scene.rooms[i].low;
      EXPECT_GE(side.minCoeff(), 2) << seed << " " << i;
      EXPECT_LE(side.maxCoeff(), 4) << seed << " " << i;
      EXPECT_EQ(group[i], group[0]) << seed << " " << i;
    }
  }
}

TEST(FlatTest, PlacesAreClearAndDoorwaysSeeBothRooms) {
  const Flat flat = FlatOf(2);
  const auto places = DrawFlatPlaces(flat, 3, 1.5, 0.3, 1);
  int doorways = 0;
  int stairs = 0;
  for (const FlatPlace& place : places) {
    doorways += place.kind == FlatPlaceKind::kDoorway;
    stairs += place.kind == FlatPlaceKind::kStairs;
  }
  EXPECT_EQ(doorways, static_cast<int>(flat.doors.size()));
  EXPECT_GE(stairs, 2);
  const FlatDoor& door = flat.doors.front();
  const SceneRoom& a = flat.scene.rooms[door.rooms[0]];
  const SceneRoom& b = flat.scene.rooms[door.rooms[1]];
  const Eigen::Vector3d in_door(door.at.x(), door.at.y(), 1.5);
  const auto middle = [](const SceneRoom& room) {
    return Eigen::Vector3d(room.Middle().x(), room.Middle().y(), 1.5);
  };
  EXPECT_TRUE(SeesThrough(flat.scene, in_door, middle(a)));
  EXPECT_TRUE(SeesThrough(flat.scene, in_door, middle(b)));
  // Corners of the two rooms on the same side of the wall between them don't see each other.
  EXPECT_FALSE(SeesThrough(flat.scene, {a.low.x() + 0.2, a.low.y() + 0.2, 2.4},
                           {b.high.x() - 0.2, b.high.y() - 0.2, 2.4}));
}

TEST(FlatTest, LightChangesWhatItLooksLikeAndWindowsBlind) {
  const Flat flat = FlatOf(1);
  const size_t lights = flat.scene.lights.size();
  size_t window = lights;
  for (size_t i = 0; i < lights; ++i) {
    if (flat.scene.lights[i].is_window) window = i;
  }
  ASSERT_LT(window, lights);
  const SceneRoom& room = flat.scene.rooms[flat.scene.lights[window].room];
  const Eigen::Vector3d at(room.Middle().x(), room.Middle().y(), 1.9);
  SceneLighting day(lights, 0.0);
  SceneLighting night(lights, 0.0);
  for (size_t i = 0; i < lights; ++i) {
    (flat.scene.lights[i].is_window ? day : night)[i] = 1;
  }
  const cv::Mat by_day = Picture(flat, day, at);
  const cv::Mat by_night = Picture(flat, night, at);
  cv::Mat difference;
  cv::absdiff(by_day, by_night, difference);
  EXPECT_GT(cv::mean(difference)[0], 8);
  EXPECT_GT(cv::countNonZero(by_day == 255), 20);  // the window
  EXPECT_GT(cv::mean(by_night)[0], 40);            // exposed for the lamps
}

TEST(FlatTest, RefusesBadOptions) {
  FlatOptions options;
  options.max_side_m = 1;
  EXPECT_THROW(MakeFlat(options), MapError);
  FlatCamera camera;
  camera.glare = 2;
  EXPECT_THROW(RenderFlat(FlatOf(1), {}, Eigen::Isometry3d::Identity(), camera), MapError);
  FlatTourOptions tour;
  tour.per_room = 0;
  EXPECT_THROW(PhotographFlat(FlatOf(1), tour), MapError);
}

}  // namespace
}  // namespace waystone
