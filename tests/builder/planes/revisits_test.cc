// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/revisits.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Dense>
#include <functional>

#include "schema/layers/planes/surfaces.h"
#include "tests/builder/planes/made_scene.h"
#include "tests/builder/planes/made_surface.h"

namespace waystone {
namespace {

using OfPoints = std::function<bool(int point)>;

// A corner that is passed twice, in keyframes 1 to 3 and 4 to 6, and the planes that a tracker
// could have made of it.
struct TwoVisits {
  MadeScene scene{1};
  std::vector<Keyframe> keyframes = Keyframes(6);
  std::vector<SampledKeyframe> images;

  TwoVisits() {
    scene.AddWall({{-1.6, -1.3, 4}, {1.5, 0, 2}, {0, 2.6, 0}}, 2 * kPointsOfWall);
    scene.AddWall({{0.1, -1.3, 6}, {1.5, 0, -2}, {0, 2.6, 0}}, 2 * kPointsOfWall);
    for (int k = 1; k <= 6; ++k) {
      keyframes[k - 1].stretch = k <= 3 ? 0 : 1;
      images.push_back({KeyframeId{k}, scene.See(PoseOf(k))});
    }
  }

  static Eigen::Isometry3d PoseOf(int64_t keyframe) {
    return PassingPose(static_cast<int>(keyframe <= 3 ? keyframe : keyframe - 2));
  }

  // The points of a wall that are chosen, as the first keyframe of a visit shows them, followed
  // through the other two.
  Plane PlaneOf(int64_t id, int64_t first, int wall, const OfPoints& chosen) const {
    Plane plane;
    plane.id = PlaneId{id};
    plane.reference = KeyframeId{first};
    plane.descriptors = Descriptors(DescriptorBytes(FeatureType::kSift));
    const Features& features = images[first - 1].features;
    for (size_t i = 0; i < features.keypoints.size(); ++i) {
      const int point = scene.PointOf(features.descriptors.row(static_cast<int>(i)));
      if (scene.points()[point].wall != wall || !chosen(point)) continue;
      plane.features.push_back({features.keypoints[i], 3, 3});
      plane.descriptors.Append(features.descriptors.row(static_cast<int>(i)));
    }
    for (int64_t k = first; k < first + 3; ++k) {
      const Eigen::Matrix3d h = k == first ? Eigen::Matrix3d::Identity()
                                           : scene.HomographyOf(wall, PoseOf(k), PoseOf(first));
      plane.views.push_back({KeyframeId{k}, h, 30});
    }
    return plane;
  }

  std::vector<Edge> Find(const std::vector<Plane>& planes, const std::vector<Edge>& edges = {},
                         const PlaneLayerOptions& options = {}) const {
    return FindRevisits(planes, edges, keyframes, images, FeatureType::kSift, options);
  }
};

bool IsEven(int point) { return point % 2 == 0; }
bool IsOdd(int point) { return point % 2 == 1; }

TEST(FindRevisits, JoinsPlanesOfTwoVisitsThatShareNoFeature) {
  const TwoVisits visits;
  const Plane first = visits.PlaneOf(1, 1, 0, IsEven);
  const Plane second = visits.PlaneOf(2, 4, 0, IsOdd);
  const std::vector<Edge> edges = visits.Find({first, second});
  ASSERT_EQ(edges.size(), 1u);
  EXPECT_EQ(edges[0].a, PlaneId{1});
  EXPECT_EQ(edges[0].b, PlaneId{2});
  EXPECT_EQ(edges[0].to.value, edges[0].from.value + 1) << "from a keyframe to the next";
  EXPECT_NEAR(edges[0].third_eigenvalue, 1, 0.05);
  EXPECT_FALSE(JoinsOneSurface(edges[0])) << "it says what was measured";
}

TEST(FindRevisits, TwoWallsOfACornerStayApart) {
  const TwoVisits visits;
  EXPECT_TRUE(
      visits.Find({visits.PlaneOf(1, 1, 0, IsEven), visits.PlaneOf(2, 4, 1, IsOdd)}).empty());
}

TEST(FindRevisits, SurfacesWithAnEdgeGetNoOther) {
  const TwoVisits visits;
  const std::vector<Plane> planes = {visits.PlaneOf(1, 1, 0, IsEven),
                                     visits.PlaneOf(2, 4, 0, IsOdd)};
  const std::vector<Edge> found = visits.Find(planes);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(visits.Find(planes, found).empty());
}

// As of a poster that hangs in both places.
TEST(FindRevisits, AFewOfAPlanesFeaturesAreNotThePlane) {
  TwoVisits visits;
  const std::vector<Plane> planes = {visits.PlaneOf(1, 1, 0, IsEven),
                                     visits.PlaneOf(2, 4, 0, IsOdd)};
  const OfPoints shown = [](int point) { return IsOdd(point) || point < 44; };
  for (int64_t k = 1; k <= 6; ++k) {
    visits.images[k - 1].features =
        visits.scene.See(TwoVisits::PoseOf(k), 0.2, k <= 3 ? OfPoints(IsEven) : shown);
  }
  EXPECT_TRUE(visits.Find(planes).empty());
  PlaneLayerOptions any_share;
  any_share.fusion.min_overlap = 0;
  EXPECT_FALSE(visits.Find(planes, {}, any_share).empty()) << "the share decides";
}

// A third of the plane's features, enough for the share, but all at one end of the wall.
TEST(FindRevisits, MatchesInOnePartOfTheWallAreAPoster) {
  TwoVisits visits;
  const std::vector<Plane> planes = {visits.PlaneOf(1, 1, 0, IsEven),
                                     visits.PlaneOf(2, 4, 0, IsOdd)};
  const auto find_where = [&](double end) {
    const OfPoints shown = [&](int point) {
      return IsOdd(point) || visits.scene.points()[point].x_world.x() < end;
    };
    for (int64_t k = 1; k <= 6; ++k) {
      visits.images[k - 1].features =
          visits.scene.See(TwoVisits::PoseOf(k), 0.2, k <= 3 ? OfPoints(IsEven) : shown);
    }
    return visits.Find(planes);
  };
  EXPECT_TRUE(find_where(-1.6 + 1.5 / 3).empty());
  EXPECT_FALSE(find_where(-1.6 + 1.5).empty()) << "the whole wall";
}

TEST(FindRevisits, OneImageOfAStretchTellsNothing) {
  TwoVisits visits;
  const std::vector<Plane> planes = {visits.PlaneOf(1, 1, 0, IsEven),
                                     visits.PlaneOf(2, 4, 0, IsOdd)};
  visits.images = {visits.images[0], visits.images[3]};
  EXPECT_TRUE(visits.Find(planes).empty());
}

TEST(FindRevisits, IsTheSameOnAnyNumberOfThreads) {
  const TwoVisits visits;
  const std::vector<Plane> planes = {
      visits.PlaneOf(1, 1, 0, IsEven), visits.PlaneOf(2, 1, 1, IsEven),
      visits.PlaneOf(3, 4, 0, IsOdd), visits.PlaneOf(4, 4, 1, IsOdd)};
  const std::vector<Edge> edges = visits.Find(planes);
  EXPECT_EQ(edges.size(), 2u);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(visits.Find(planes), edges);
}

}  // namespace
}  // namespace waystone
