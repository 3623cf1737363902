// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/outline.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/homography/homography.h"
#include "schema/layers/names/place_names.h"

namespace waystone {
namespace {

using Eigen::Vector2d;
using Points = std::vector<Vector2d>;

constexpr double kStep = 10;

// A grid of points over what `shows` says, each moved by up to a pixel.
Points GridOver(const Vector2d& size, Random& random, auto&& shows) {
  Points points;
  for (double y = 0; y <= size.y(); y += kStep) {
    for (double x = 0; x <= size.x(); x += kStep) {
      if (!shows(x, y)) continue;
      points.emplace_back(x + random.Uniform(-1, 1), y + random.Uniform(-1, 1));
    }
  }
  return points;
}

double Area(const Points& ring) {
  double twice = 0;
  for (size_t i = 0; i < ring.size(); ++i) {
    const Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

TEST(ConvexHull, HasTheOutermostPoints) {
  const Points hull = ConvexHull({{0, 0}, {50, 40}, {100, 0}, {10, 30}, {100, 80}, {0, 80}});
  ASSERT_EQ(hull.size(), 4u);
  for (const Vector2d& corner :
       {Vector2d(0, 0), Vector2d(100, 0), Vector2d(100, 80), Vector2d(0, 80)}) {
    EXPECT_NE(std::find(hull.begin(), hull.end(), corner), hull.end());
  }
}

TEST(SupportedPolygon, TakesAnyNumberOfPoints) {
  EXPECT_TRUE(SupportedPolygon({}, {}, 50).empty());
  EXPECT_EQ(SupportedPolygon({{3, 4}}, {}, 50).size(), 1u);
  EXPECT_EQ(SupportedPolygon({{3, 4}, {5, 4}}, {}, 50).size(), 2u);
  EXPECT_EQ(SupportedPolygon({{3, 4}, {3, 4}, {3, 4}}, {}, 50).size(), 1u);
  EXPECT_EQ(SupportedPolygon({{0, 0}, {10, 10}, {20, 20}, {40, 40}}, {}, 50).size(), 2u);
  EXPECT_NEAR(Area(SupportedPolygon({{0, 0}, {40, 0}, {0, 30}}, {}, 5)), 600, 1e-6)
      << "one triangle is the least that there is";
}

TEST(SupportedPolygon, OfConvexPointsIsTheirHull) {
  Random random(1);
  const Points points = GridOver({200, 100}, random, [](double, double) { return true; });
  const Points outline = SupportedPolygon(points, {}, 1000);
  // The triangulation may leave out slivers at the hull.
  EXPECT_NEAR(Area(outline) / std::abs(Area(ConvexHull(points))), 1, 0.01);
}

TEST(SupportedPolygon, FollowsAConcaveShape) {
  Random random(2);
  const auto in_l = [](double x, double y) { return x <= 100 || y <= 100; };
  const Points outline = SupportedPolygon(GridOver({300, 300}, random, in_l), {}, 3 * kStep);
  EXPECT_NEAR(Area(outline), 50'000, 2'000);
  EXPECT_TRUE(Holds(outline, {50, 250}));
  EXPECT_TRUE(Holds(outline, {250, 50}));
  EXPECT_FALSE(Holds(outline, {180, 180}));
}

TEST(SupportedPolygon, LeavesPartsThatAreFarApartInOnePiece) {
  Random random(3);
  const auto two = [](double x, double) { return x <= 100 || x >= 300; };
  const Points outline = SupportedPolygon(GridOver({400, 100}, random, two), {}, 3 * kStep);
  EXPECT_TRUE(Holds(outline, {50, 50}));
  EXPECT_TRUE(Holds(outline, {350, 50}));
  EXPECT_GT(Area(outline), 20'000 * 0.9);
}

TEST(SupportedPolygon, LeavesOutWhatBelongsToSomethingElse) {
  Random random(4);
  const auto apart = [](double x, double y) { return std::hypot(x - 150, y - 100) > 55; };
  const Points points = GridOver({300, 200}, random, apart);
  Points others;
  for (int i = 0; i < 400; ++i) {
    const Vector2d at(random.Uniform(-45, 45), random.Uniform(-45, 45));
    if (at.norm() < 45) others.emplace_back(150 + at.x(), 100 + at.y());
  }
  const Points whole = SupportedPolygon(points, {}, 1000);
  EXPECT_TRUE(Holds(whole, {150, 100}));
  const Points outline = SupportedPolygon(points, others, 1000);
  EXPECT_FALSE(Holds(outline, {150, 100})) << "a hole";
  EXPECT_TRUE(Holds(outline, {30, 100}));
  EXPECT_TRUE(Holds(outline, {270, 100}));
  EXPECT_TRUE(Holds(outline, {150, 190}));
  EXPECT_LT(Area(outline), Area(whole) - 5'000) << "the area of a ring with a cut";
  // At the border the same is a bay.
  Points moved;
  for (const Vector2d& p : others) moved.emplace_back(p.x(), p.y() + 100);
  const Points bay = SupportedPolygon(points, moved, 1000);
  EXPECT_FALSE(Holds(bay, {150, 195}));
  EXPECT_TRUE(Holds(bay, {30, 195}));
}

// Whatever the points, every one of them that isn't cut out lies in the outline or on it.
TEST(SupportedPolygon, HoldsItsPoints) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    Points points;
    const int count = 3 + static_cast<int>(random.Uniform(0, 60));
    for (int i = 0; i < count; ++i) {
      points.emplace_back(random.Uniform(-20, 640), std::floor(random.Uniform(0, 20)) * 20);
    }
    const Points outline = SupportedPolygon(points, {}, 40);
    ASSERT_GE(outline.size(), 3u);
    EXPECT_GT(Area(outline), 0) << seed;
    for (const Vector2d& p : points) {
      const bool corner =
          std::ranges::any_of(outline, [&](const Vector2d& c) { return (c - p).norm() < 0.1; });
      EXPECT_TRUE(corner || Holds(outline, p)) << seed << ": " << p.transpose();
    }
  }
}

TEST(SupportedPolygon, TakesPointsThatNearlyCoincideOrAreFarAway) {
  Random random(6);
  Points points;
  for (int i = 0; i < 2000; ++i) {
    points.emplace_back(random.Uniform(0, 3), 1e-4 * std::round(random.Uniform(0, 20'000)));
  }
  const Points outline = SupportedPolygon(points, {{1e300, -1e300}}, 1);
  EXPECT_NEAR(Area(outline), 6, 0.5);
  for (const double far : {1e30, -1e30, 1e300}) points.emplace_back(far, 5);
  points.emplace_back(NAN, NAN);
  EXPECT_EQ(SupportedPolygon(points, {{1e300, -1e300}}, 1), outline);
}

TEST(OutlinePlanes, CutsOutPlanesOfOtherSurfacesOnly) {
  Random random(5);
  MapData map;
  map.keyframes.push_back({KeyframeId{1}, SequenceId{1}, 0, 0, "a.jpg", {}, 640, 480, {}, {}});
  const auto add_plane = [&](int id, const Points& points) {
    Plane plane;
    plane.id = PlaneId{id};
    plane.reference = KeyframeId{1};
    for (const Vector2d& p : points) {
      plane.features.push_back(
          {{static_cast<float>(p.x()), static_cast<float>(p.y()), 4, 0}, 2, 2});
    }
    plane.views.push_back({KeyframeId{1}, Eigen::Matrix3d::Identity(), 10});
    map.planes.push_back(plane);
  };
  const auto picture = [](double x, double y) { return std::hypot(x - 150, y - 100) < 30; };
  add_plane(1, GridOver({300, 200}, random,
                        [&](double x, double y) { return std::hypot(x - 150, y - 100) > 40; }));
  add_plane(2, GridOver({300, 200}, random, picture));
  map.edges.push_back({PlaneId{1}, PlaneId{2}, KeyframeId{1}, KeyframeId{1},
                       Eigen::Vector3d(1, 1, 1.5).asDiagonal(), 1.5});
  OutlinePlanes(map);
  EXPECT_FALSE(Holds(map.planes[0].outline, {150, 100}));
  EXPECT_TRUE(Holds(map.planes[1].outline, {150, 100}));
  map.edges[0].homology.setIdentity();
  OutlinePlanes(map);
  EXPECT_TRUE(Holds(map.planes[0].outline, {150, 100})) << "a part of the same surface";
}

// Its image takes the features left of x = 100 to the front of a camera and those right of it
// behind it; of these (250, 0) to (150, 100).
const Eigen::Matrix3d kPartlyBehind{{1 - 3.1667, 0, 316.67}, {-1, 1, 100}, {-0.01, 0, 1}};

Plane PlaneWith(int id, const Points& points) {
  Plane plane;
  plane.id = PlaneId{id};
  plane.reference = KeyframeId{id};
  for (const Vector2d& p : points) {
    plane.features.push_back({{static_cast<float>(p.x()), static_cast<float>(p.y()), 4, 0}, 2, 2});
  }
  return plane;
}

TEST(FeaturesInsideHull, LeavesOutWhatIsBehindTheCamera) {
  const Plane plane = PlaneWith(1, {{20, 0}, {250, 0}, {40, 20}, {50, 900}});
  const Points hull{{0, 0}, {600, 0}, {600, 400}, {0, 400}};
  EXPECT_EQ(FeaturesInsideHull(plane, kPartlyBehind, hull), (std::vector{0, 2}));
}

TEST(OutlinePlanes, FeaturesBehindTheCameraCutNothingOut) {
  Random random(6);
  MapData map;
  for (const int id : {1, 2}) {
    map.keyframes.push_back({KeyframeId{id}, SequenceId{1}, id, 0, "a.jpg", {}, 640, 480, {}, {}});
  }
  map.planes.push_back(PlaneWith(1, GridOver({300, 200}, random, [](double x, double y) {
                                   return std::hypot(x - 150, y - 100) > 40;
                                 })));
  map.planes[0].views.push_back({KeyframeId{1}, Eigen::Matrix3d::Identity(), 10});
  const auto outline_with = [&](const Points& other) {
    map.planes.resize(1);
    map.planes.push_back(PlaneWith(2, other));
    map.planes[1].views = {{KeyframeId{1}, kPartlyBehind.inverse(), 10},
                           {KeyframeId{2}, Eigen::Matrix3d::Identity(), 10}};
    OutlinePlanes(map);
    return map.planes[0].outline;
  };
  const Points behind{{250, 0}, {245, 5}, {255, 5}, {250, 10}};
  EXPECT_NEAR((Apply(kPartlyBehind, behind[0]) - Vector2d(150, 100)).norm(), 0, 1);
  EXPECT_TRUE(Holds(outline_with(behind), {150, 100}));
}

}  // namespace
}  // namespace waystone
