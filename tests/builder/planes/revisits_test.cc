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

bool IsEven(int point) { return point % 2 == 0; }
bool IsOdd(int point) { return point % 2 == 1; }

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

  Revisits Find(const std::vector<Plane>& planes, const std::vector<Edge>& edges = {}) const {
    ProgressReporter nobody;
    return FindRevisits(planes, edges, keyframes, images, FeatureType::kSift, {}, nobody);
  }

  // Both visits' planes of the first wall, without a feature in common.
  std::vector<Plane> PlanesOfOneWall() const {
    return {PlaneOf(1, 1, 0, IsEven), PlaneOf(2, 4, 0, IsOdd)};
  }

  // The same planes, when the second visit's images show only `again` of the first one's features.
  Revisits FindShowing(const OfPoints& again) {
    const std::vector<Plane> planes = PlanesOfOneWall();
    const OfPoints shown = [&](int point) { return IsOdd(point) || again(point); };
    for (int64_t k = 1; k <= 6; ++k) {
      images[k - 1].features = scene.See(PoseOf(k), 0.2, k <= 3 ? OfPoints(IsEven) : shown);
    }
    return Find(planes);
  }
};

TEST(FindRevisits, JoinsPlanesOfTwoVisitsThatShareNoFeature) {
  const TwoVisits visits;
  const std::vector<Edge> edges = visits.Find(visits.PlanesOfOneWall()).edges;
  ASSERT_EQ(edges.size(), 1u);
  EXPECT_EQ(edges[0].a, PlaneId{1});
  EXPECT_EQ(edges[0].b, PlaneId{2});
  EXPECT_EQ(edges[0].to.value, edges[0].from.value + 1) << "from a keyframe to the next";
  EXPECT_NEAR(edges[0].third_eigenvalue, 1, 0.05);
  EXPECT_FALSE(JoinsOneSurface(edges[0])) << "it says what was measured";
}

TEST(FindRevisits, GivesEachPlaneAViewOfTheImagesThatShowItAgain) {
  const TwoVisits visits;
  const std::vector<Plane> planes = visits.PlanesOfOneWall();
  const std::vector<PlaneSeenAgain> seen = visits.Find(planes).seen;
  ASSERT_EQ(seen.size(), 6u) << "the first plane in three images, the second one in the others";
  for (size_t i = 0; i < seen.size(); ++i) {
    const auto& [plane, view] = seen[i];
    EXPECT_EQ(view.keyframe, KeyframeId{static_cast<int64_t>(i) + 1}) << "by keyframe";
    EXPECT_EQ(plane, PlaneId{view.keyframe.value <= 3 ? 2 : 1});
    EXPECT_GE(view.inliers, 30);
    const Plane& seen_plane = planes[plane.value - 1];
    const Eigen::Matrix3d truth = visits.scene.HomographyOf(
        0, TwoVisits::PoseOf(view.keyframe.value), TwoVisits::PoseOf(seen_plane.reference.value));
    for (const PlaneFeature& feature : seen_plane.features) {
      const Eigen::Vector2d x = PositionOf(feature.reference);
      const Eigen::Vector2d in_keyframe = Apply(truth.inverse(), x);
      EXPECT_LT((Apply(view.reference_from_keyframe, in_keyframe) - x).norm(), 3);
    }
  }
}

TEST(FindRevisits, TwoWallsOfACornerStayApart) {
  const TwoVisits visits;
  const Revisits found =
      visits.Find({visits.PlaneOf(1, 1, 0, IsEven), visits.PlaneOf(2, 4, 1, IsOdd)});
  EXPECT_TRUE(found.edges.empty());
  EXPECT_EQ(found.seen.size(), 6u);
}

TEST(FindRevisits, SurfacesWithAnEdgeGetNoOther) {
  const TwoVisits visits;
  const std::vector<Plane> planes = visits.PlanesOfOneWall();
  const Revisits found = visits.Find(planes);
  ASSERT_FALSE(found.edges.empty());
  const Revisits again = visits.Find(planes, found.edges);
  EXPECT_TRUE(again.edges.empty());
  EXPECT_EQ(again.seen, found.seen);
}

// What a plane has kept from many images, no single one shows.
TEST(FindRevisits, AFifthOfThePlaneIsEnoughIfItIsAllOverIt) {
  const Revisits found = TwoVisits().FindShowing([](int point) { return point % 10 == 0; });
  EXPECT_FALSE(found.edges.empty());
  EXPECT_FALSE(found.seen.empty());
}

TEST(FindRevisits, AFewMatchesAreNotThePlane) {
  const Revisits found = TwoVisits().FindShowing([](int point) { return point < 20; });
  EXPECT_TRUE(found.edges.empty());
  EXPECT_TRUE(found.seen.empty());
}

// A third of the plane's features, all at one end of the wall.
TEST(FindRevisits, MatchesInOnePartOfTheWallAreAPoster) {
  const auto find_where = [&](double end) {
    TwoVisits visits;
    return visits.FindShowing(
        [&](int point) { return visits.scene.points()[point].x_world.x() < end; });
  };
  const Revisits poster = find_where(-1.6 + 1.5 / 3);
  EXPECT_TRUE(poster.edges.empty());
  EXPECT_TRUE(poster.seen.empty());
  EXPECT_FALSE(find_where(-1.6 + 1.5).edges.empty()) << "the whole wall";
}

TEST(FindRevisits, OneImageOfAStretchGivesAViewAndNoEdge) {
  TwoVisits visits;
  const std::vector<Plane> planes = visits.PlanesOfOneWall();
  visits.images = {visits.images[0], visits.images[3]};
  const Revisits found = visits.Find(planes);
  EXPECT_TRUE(found.edges.empty());
  EXPECT_EQ(found.seen.size(), 2u);
}

TEST(FindRevisits, IsTheSameOnAnyNumberOfThreads) {
  const TwoVisits visits;
  const std::vector<Plane> planes = {
      visits.PlaneOf(1, 1, 0, IsEven), visits.PlaneOf(2, 1, 1, IsEven),
      visits.PlaneOf(3, 4, 0, IsOdd), visits.PlaneOf(4, 4, 1, IsOdd)};
  const Revisits found = visits.Find(planes);
  EXPECT_EQ(found.edges.size(), 2u);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Revisits by_one = visits.Find(planes);
  EXPECT_EQ(by_one.edges, found.edges);
  EXPECT_EQ(by_one.seen, found.seen);
}

}  // namespace
}  // namespace waystone
