// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/world_revisits.h"

#include <gtest/gtest.h>

namespace waystone::bench {
namespace {

constexpr int kSurface = 7;
constexpr int kKeyframes = 9;

// Keyframes 0 to 2 and 6 to 8 see one surface; the two visits share matches by keyframes 1 and 7.
SharedPlanes TwoVisits(bool match) {
  SharedPlanes shared(kKeyframes);
  for (int b = 0; b < kKeyframes; ++b) shared[b].resize(b);
  for (const int k : {1, 2, 7, 8}) shared[k][k - 1] = {kSurface};
  if (match) shared[7][1] = {kSurface};
  return shared;
}

Plane PlaneSeenIn(int id, const std::vector<int>& keyframes) {
  Plane plane;
  plane.id = PlaneId{id};
  for (const int k : keyframes) {
    plane.views.push_back({KeyframeId{k + 1}, Eigen::Matrix3d::Identity(), 20});
  }
  return plane;
}

MapData MapOf(const std::vector<Plane>& planes) {
  MapData map;
  map.keyframes.resize(kKeyframes);
  for (int k = 0; k < kKeyframes; ++k) map.keyframes[k].id = KeyframeId{k + 1};
  map.planes = planes;
  return map;
}

const std::map<PlaneId, int> kOwners = {{PlaneId{1}, kSurface}, {PlaneId{2}, kSurface}};

TEST(CountRevisits, OnePlaneOfBothVisitsJoinsThem) {
  const RevisitFigures figures =
      CountRevisits(TwoVisits(true), MapOf({PlaneSeenIn(1, {0, 1, 2, 6, 7})}), kOwners);
  EXPECT_EQ(figures.pairs, 1);
  EXPECT_EQ(figures.seen_again, 1);
  EXPECT_EQ(figures.one_plane, 1);
}

TEST(CountRevisits, TwoPlanesJoinThemAsOneSurfaceOrByAnEdgeOrNotAtAll) {
  MapData map = MapOf({PlaneSeenIn(1, {0, 1}), PlaneSeenIn(2, {7, 8})});
  EXPECT_EQ(CountRevisits(TwoVisits(true), map, kOwners).apart, 1);
  const Eigen::Matrix3d two_planes = Eigen::Vector3d(1, 1, 1.5).asDiagonal();
  map.edges.push_back({PlaneId{1}, PlaneId{2}, KeyframeId{7}, KeyframeId{8}, two_planes, 1.5});
  const RevisitFigures by_edge = CountRevisits(TwoVisits(true), map, kOwners);
  EXPECT_EQ(by_edge.joined_by_edge, 1);
  EXPECT_EQ(by_edge.apart, 0);
  map.edges[0].homology.setIdentity();
  const RevisitFigures as_surface = CountRevisits(TwoVisits(true), map, kOwners);
  EXPECT_EQ(as_surface.one_surface, 1);
  EXPECT_EQ(as_surface.joined_by_edge, 0);
}

TEST(CountRevisits, AVisitWithoutAPlaneIsNotJoined) {
  const MapData map = MapOf({PlaneSeenIn(1, {0, 1, 2}), PlaneSeenIn(3, {7, 8})});
  const RevisitFigures figures = CountRevisits(TwoVisits(true), map, kOwners);
  EXPECT_EQ(figures.seen_again, 1);
  EXPECT_EQ(figures.no_plane, 1) << "plane 3 shows no one surface";
}

TEST(CountRevisits, VisitsThatShareNothingAreCountedAndNotJudged) {
  const RevisitFigures figures =
      CountRevisits(TwoVisits(false), MapOf({PlaneSeenIn(1, {0, 1, 2, 6, 7})}), kOwners);
  EXPECT_EQ(figures.pairs, 1);
  EXPECT_EQ(figures.too_few_matches, 1);
  EXPECT_EQ(figures.seen_again, 0);
}

}  // namespace
}  // namespace waystone::bench
