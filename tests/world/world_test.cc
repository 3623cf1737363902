// SPDX-License-Identifier: Apache-2.0
#include "world/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <opencv2/features2d.hpp>
#include <set>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

int CountKind(const World& world, SurfaceKind kind) {
  return static_cast<int>(
      std::count_if(world.planes().begin(), world.planes().end(),
                    [&](const WorldPlane& plane) { return plane.kind == kind; }));
}

bool AreNeighbours(const World& world, int a, int b) {
  const std::vector<int>& all = world.PlaneById(a).neighbours;
  return std::find(all.begin(), all.end(), b) != all.end();
}

TEST(World, MergesCoplanarWallsAndKeepsTheirPiecesApart) {
  const World& world = TwoRoomWorld();
  EXPECT_EQ(CountKind(world, SurfaceKind::kFloor), 1);
  EXPECT_EQ(CountKind(world, SurfaceKind::kCeiling), 1);
  EXPECT_EQ(CountKind(world, SurfaceKind::kLintel), 1);
  // North and south walls of both rooms are coplanar; besides them there are the outer west and
  // east walls, the middle wall's two sides, and the door's two jambs.
  EXPECT_EQ(CountKind(world, SurfaceKind::kWall), 2 + 2 + 2 + 2);
  int walls_of_two = 0;
  for (const WorldPlane& plane : world.planes()) {
    if (plane.kind == SurfaceKind::kWall && plane.faces.size() == 2) ++walls_of_two;
  }
  EXPECT_EQ(walls_of_two, 2) << "a lintel joins the wall beside it, a gap parts faces";
}

TEST(World, PlanesAreRightHandedRectanglesAroundTheirFaces) {
  const World& world = TwoRoomWorld();
  for (const WorldPlane& plane : world.planes()) {
    EXPECT_TRUE(plane.normal.isApprox(-plane.u_axis.cross(plane.v_axis)));
    EXPECT_NEAR(plane.normal.norm(), 1.0, 1e-12);
    for (const int id : plane.faces) {
      const WorldFace& face = world.FaceById(id);
      EXPECT_EQ(face.plane, plane.id);
      const Eigen::Vector3d offset = face.origin - plane.origin;
      EXPECT_NEAR(offset.dot(plane.normal), 0.0, 1e-12);
      EXPECT_GE(offset.dot(plane.u_axis), -1e-12);
      EXPECT_LE(offset.dot(plane.u_axis) + face.size_m.x(), plane.size_m.x() + 1e-12);
    }
  }
}

TEST(World, AdjacencyIsSymmetricAndMeansASharedEdge) {
  const World& world = TwoRoomWorld();
  for (const WorldPlane& plane : world.planes()) {
    EXPECT_TRUE(std::is_sorted(plane.neighbours.begin(), plane.neighbours.end()));
    for (const int other : plane.neighbours) {
      EXPECT_NE(other, plane.id);
      EXPECT_TRUE(AreNeighbours(world, other, plane.id));
      EXPECT_NEAR(plane.normal.dot(world.PlaneById(other).normal), 0.0, 1e-12);
    }
    if (plane.kind == SurfaceKind::kWall) {
      EXPECT_TRUE(AreNeighbours(world, plane.id, 1)) << "walls stand on the floor";
    }
  }
  EXPECT_FALSE(AreNeighbours(world, 1, 2));
}

// The nearest plane of any face whose rectangle the ray meets from the front.
RayHit BruteForce(const World& world, const Eigen::Vector3d& origin,
                  const Eigen::Vector3d& direction) {
  RayHit best{0, 1e9};
  for (const WorldFace& face : world.faces()) {
    const WorldPlane& plane = world.PlaneById(face.plane);
    const double speed = plane.normal.dot(direction);
    const double t = plane.normal.dot(plane.origin - origin) / speed;
    if (speed >= 0.0 || t <= 0.0 || t >= best.t) continue;
    const Eigen::Vector3d point = origin + t * direction;
    const double u = (point - face.origin).dot(plane.u_axis);
    const double v = (point - face.origin).dot(plane.v_axis);
    bool hits = face.spans.empty();
    if (plane.kind == SurfaceKind::kLintel) {
      const double cell = world.plan().size.cell_m;
      const int row = world.plan().rows - 1 - static_cast<int>(std::floor(point.y() / cell));
      hits = world.plan().IsDoor(static_cast<int>(std::floor(point.x() / cell)), row);
    }
    for (const FaceSpan& span : face.spans) {
      const double left = span.cell * world.plan().size.cell_m;
      hits = hits || (u >= left && u <= left + world.plan().size.cell_m && v >= span.top_m &&
                      v <= span.bottom_m);
    }
    if (hits) best = {face.id, t};
  }
  return best;
}

TEST(World, CastsRaysAsPlaneByPlaneIntersectionDoes) {
  const World& world = TwoRoomWorld();
  Random random(7);
  std::set<int> faces;
  for (int i = 0; i < 20000; ++i) {
    Eigen::Vector3d origin(random.Uniform(0.5, 7.0), random.Uniform(0.5, 3.5),
                           random.Uniform(0.1, 2.5));
    if (!world.IsInside(origin)) continue;
    const Eigen::Vector3d direction(random.Normal(), random.Normal(), 0.4 * random.Normal());
    const RayHit hit = world.Cast(origin, direction);
    const RayHit truth = BruteForce(world, origin, direction);
    ASSERT_EQ(hit.face, truth.face) << origin.transpose() << " to " << direction.transpose();
    ASSERT_NEAR(hit.t, truth.t, 1e-9 * (1.0 + truth.t));
    faces.insert(hit.face);
  }
  EXPECT_EQ(faces.size(), world.faces().size()) << "every face is seen from somewhere";
}

TEST(World, CastsAlongAxesAndStraightDown) {
  const World& world = TwoRoomWorld();
  const Eigen::Vector3d origin(1.5, 1.0, 1.0);
  EXPECT_DOUBLE_EQ(world.Cast(origin, -Eigen::Vector3d::UnitZ()).t, 1.0);
  EXPECT_EQ(world.Cast(origin, Eigen::Vector3d::UnitZ()).face, 2);
  EXPECT_DOUBLE_EQ(world.Cast(origin, -Eigen::Vector3d::UnitX()).t, 1.0);
  EXPECT_DOUBLE_EQ(world.Cast(origin, -2.0 * Eigen::Vector3d::UnitY()).t, 0.25);
}

TEST(World, KnowsWhatIsInside) {
  const World& world = TwoRoomWorld();
  EXPECT_TRUE(world.IsInside({1.5, 1.0, 1.0}));
  EXPECT_FALSE(world.IsInside({1.5, 1.0, 2.7}));
  EXPECT_FALSE(world.IsInside({1.5, 1.0, -0.1}));
  EXPECT_FALSE(world.IsInside({0.2, 1.0, 1.0}));
  EXPECT_TRUE(world.IsInside({3.75, 2.0, 2.0}));
  EXPECT_FALSE(world.IsInside({3.75, 2.0, 2.1})) << "in the lintel";
}

// Storeys share the places of posters and some of their pictures; a storey's looks are its own
// otherwise.
TEST(World, StoreysShareSomeOfTheirLooks) {
  WorldOptions options = TestOptions();
  options.poster_probability = 1.0;
  options.alike_share = 0.5;
  const World ground(TwoRooms(), options);
  options.storey = 1;
  const World first(TwoRooms(), options);
  options.alike_share = 1;
  const World copy(TwoRooms(), options);
  ASSERT_EQ(first.posters().size(), ground.posters().size());
  size_t same = 0;
  for (size_t i = 0; i < ground.posters().size(); ++i) {
    EXPECT_EQ(first.posters()[i].top_left_m, ground.posters()[i].top_left_m);
    EXPECT_EQ(copy.posters()[i].picture, ground.posters()[i].picture);
    same += first.posters()[i].picture == ground.posters()[i].picture;
  }
  EXPECT_LT(same, ground.posters().size());
  EXPECT_GT(same, 0U);
  WorldOptions other = options;
  other.storey = 2;
  EXPECT_NE(SeedOfStorey(other), SeedOfStorey(options));
  other.storey = 0;
  EXPECT_EQ(SeedOfStorey(other), other.seed);
}

TEST(World, RepeatedPostersShowOnePicture) {
  WorldOptions options = TestOptions();
  options.poster_probability = 1.0;
  options.repeat_poster = 1.0;
  const World same(TwoRooms(), options);
  options.repeat_poster = 0.0;
  const World unlike(TwoRooms(), options);
  const auto pictures = [](const World& world) {
    std::set<uint64_t> all;
    std::set<int> faces;
    for (const WorldPoster& poster : world.posters()) {
      all.insert(poster.picture);
      faces.insert(poster.face);
    }
    EXPECT_GE(faces.size(), 3U) << "posters on several walls";
    return all.size();
  };
  EXPECT_EQ(pictures(same), 1U);
  EXPECT_EQ(pictures(unlike), unlike.posters().size());
}

// The grey values of a poster, seen by rays that hit it straight on.
cv::Mat LookAtPoster(const World& world, const WorldPoster& poster) {
  const WorldFace& face = world.FaceById(poster.face);
  const WorldPlane& plane = world.PlaneById(face.plane);
  const double texel = world.options().texel_m;
  cv::Mat seen(100, 60, CV_32FC1);
  for (int y = 0; y < seen.rows; ++y) {
    for (int x = 0; x < seen.cols; ++x) {
      const Eigen::Vector3d point = face.origin +
                                    (poster.top_left_m.x() + (x + 0.5) * texel) * plane.u_axis +
                                    (poster.top_left_m.y() + (y + 0.5) * texel) * plane.v_axis;
      const Eigen::Vector3d eye = point + 0.3 * plane.normal;
      const RayHit hit = world.Cast(eye, -plane.normal);
      EXPECT_EQ(hit.face, face.id);
      seen.at<float>(y, x) = world.Shade(eye, -plane.normal, hit, 1e-4);
    }
  }
  return seen;
}

TEST(World, LetteredWallsCarryTheirPoster) {
  WorldOptions options = TestOptions();
  options.poster_probability = 0.0;
  const World world(ParseFloorPlan("##a##b#\n#.....#\n#.....#\n#.....#\n####a##\n", {1.0}),
                    options);
  ASSERT_EQ(world.posters().size(), 3U);
  std::vector<cv::Mat> seen;
  for (const WorldPoster& poster : world.posters()) seen.push_back(LookAtPoster(world, poster));
  std::vector<double> differences;
  for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    const auto i = static_cast<size_t>(a);
    const auto k = static_cast<size_t>(b);
    const bool same = world.posters()[i].picture == world.posters()[k].picture;
    const double mean = cv::norm(seen[i], seen[k], cv::NORM_L1) / seen[i].total();
    differences.push_back(same ? 1.0 : 0.0);
    if (same) {
      EXPECT_LT(mean, 0.5);
    } else {
      EXPECT_GT(mean, 20.0);
    }
  }
  EXPECT_EQ(std::count(differences.begin(), differences.end(), 1.0), 1) << "two a, one b";
}

TEST(World, BareWallsHaveFarFewerCorners) {
  WorldOptions options = TestOptions();
  options.poster_probability = 0.0;
  const World rich(TwoRooms(), options);
  options.bare_walls = 1.0;
  const World bare(TwoRooms(), options);
  const auto corners = [](const World& world) {
    std::vector<cv::KeyPoint> found;
    const Eigen::Isometry3d pose = WorldFromCamera({2.2, 2.0, 1.3}, 3.0);
    cv::FAST(Render(world, PinholeCamera(320, 240, 0.7), pose).grey, found, 15);
    return found.size();
  };
  EXPECT_GT(corners(rich), 100U);
  EXPECT_LT(corners(bare) * 10, corners(rich));
}

// The strongest change from one row of a picture to the next, as a mean over the row: shapes at any
// angle cancel out, level bars add up. Of a wall seen rig-on.
double StrongestLevel(const World& world) {
  const Eigen::Isometry3d pose = WorldFromCamera({2.2, 2.0, 1.3}, 0.5 * std::numbers::pi);
  const cv::Mat grey = Render(world, PinholeCamera(320, 240, 1.1), pose).grey;
  cv::Mat rows;
  cv::reduce(grey, rows, 1, cv::REDUCE_AVG, CV_32F);
  double strongest = 0;
  for (int y = 1; y < rows.rows; ++y) {
    strongest = std::max<double>(strongest, std::abs(rows.at<float>(y) - rows.at<float>(y - 1)));
  }
  return strongest;
}

TEST(World, TrimRunsAlongTheBuilding) {
  WorldOptions options = TestOptions();
  options.poster_probability = 0.0;
  const World plain(TwoRooms(), options);
  options.trim = true;
  const World trimmed(TwoRooms(), options);
  EXPECT_GT(StrongestLevel(trimmed), 2 * StrongestLevel(plain));
}

TEST(World, RefusesBadOptionsAndTooManyTexels) {
  WorldOptions options;
  options.bare_walls = 1.5;
  EXPECT_THROW(World(TwoRooms(), options), MapError);
  options = {};
  options.texel_m = 0.0;
  EXPECT_THROW(World(TwoRooms(), options), MapError);
  options.texel_m = 0.001;
  EXPECT_THROW(World(DemoPlan(), options), MapError);
}

}  // namespace
}  // namespace waystone
