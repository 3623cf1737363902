// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/fusion.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "builder/planes/plane_features.h"
#include "core/homography/homography.h"
#include "tests/builder/planes/every_pair.h"
#include "tests/builder/planes/made_surface.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr FeatureType kType = FeatureType::kSift;

Edge EdgeBetween(int64_t a, int64_t b, double third = 1.2) {
  Edge edge{PlaneId{a}, PlaneId{b}, KeyframeId{1}, KeyframeId{2}, Matrix3d::Identity(), third};
  edge.homology(0, 0) = third;
  return edge;
}

std::vector<std::pair<int64_t, int64_t>> PairsOf(const std::vector<Edge>& edges) {
  std::vector<std::pair<int64_t, int64_t>> pairs;
  for (const Edge& edge : edges) pairs.emplace_back(edge.a.value, edge.b.value);
  return pairs;
}

std::vector<int64_t> IdsOf(const std::vector<Plane>& planes) {
  std::vector<int64_t> ids;
  for (const Plane& plane : planes) ids.push_back(plane.id.value);
  return ids;
}

using Ids = std::vector<int64_t>;
using Pairs = std::vector<std::pair<int64_t, int64_t>>;

// Surface 1 is seen as plane 1 and, later, as plane 3; planes 2 and 4 are others.
struct SeenAgain {
  Random random;
  Surface wall;
  Matrix3d h;  // of the second look
  std::vector<Plane> planes;

  explicit SeenAgain(uint64_t seed) : random(seed) {
    wall = RandomSurface(random);
    h = MildHomography(random);
    planes = {PlaneOf(1, 1, wall, Matrix3d::Identity(), random),
              PlaneOf(2, 3, RandomSurface(random), Matrix3d::Identity(), random),
              PlaneOf(3, 5, wall, h, random),
              PlaneOf(4, 7, RandomSurface(random), Matrix3d::Identity(), random)};
  }

  FusionResult Fuse(const std::vector<Edge>& edges, const PlaneLayerOptions& options = {}) const {
    return FusePlanes(planes, edges, Keyframes(10), kType, options);
  }
};

std::optional<FusionMatch> Matched(const Plane& m, const Plane& n) {
  return MatchPlanes(m, PackedRows(kType, m.descriptors), n, {});
}

TEST(MatchPlanes, FindsTheHomographyBetweenTwoLooks) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const SeenAgain scene(seed);
    const auto match = Matched(scene.planes[0], scene.planes[2]);
    ASSERT_TRUE(match) << "seed " << seed;
    EXPECT_GE(match->inliers.size(), 90u);
    const Matrix3d truth = scene.h.inverse();
    for (const Vector2d& x : scene.wall.points) {
      EXPECT_LT(
          (Apply(match->m_from_n.b_from_a, Apply(scene.h, x)) - Apply(truth, Apply(scene.h, x)))
              .norm(),
          1);
    }
  }
}

TEST(MatchPlanes, NothingForDifferentPlanes) {
  const SeenAgain scene(1);
  EXPECT_FALSE(Matched(scene.planes[0], scene.planes[1]));
}

TEST(FusePlanes, APlaneSeenAgainIsFused) {
  const SeenAgain scene(2);
  const FusionResult result = scene.Fuse({});
  EXPECT_EQ(result.fused, 1);
  ASSERT_EQ(IdsOf(result.planes), (Ids{1, 2, 4}));
  const Plane& fused = result.planes[0];
  EXPECT_EQ(fused.reference, KeyframeId{1});
  ASSERT_EQ(fused.views.size(), 4u);
  constexpr std::array<int64_t, 4> kKeyframes = {1, 2, 5, 6};
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(fused.views[i].keyframe.value, kKeyframes[i]);
  EXPECT_EQ(fused.views[0].reference_from_keyframe, Matrix3d::Identity());
  for (const Vector2d& x : scene.wall.points) {
    EXPECT_LT((Apply(fused.views[2].reference_from_keyframe, Apply(scene.h, x)) - x).norm(), 1);
  }
  EXPECT_EQ(result.planes[1], scene.planes[1]) << "the others stay as they are";
  EXPECT_EQ(result.planes[2], scene.planes[3]);
}

// What the second look found where the first one's reference image is far away could only be
// extrapolated.
TEST(FusePlanes, FeaturesBeyondTheReferenceImageAreLeftOut) {
  SeenAgain scene(3);
  Matrix3d aside = Matrix3d::Identity();
  aside(0, 2) = -200;
  Surface beyond;
  beyond.Add(6, {720, 100}, {820, 380}, scene.random);
  Surface second = scene.wall;
  second.Add(beyond);
  scene.planes[2] = PlaneOf(3, 5, second, aside, scene.random);
  const FusionResult result = scene.Fuse({});
  ASSERT_EQ(result.fused, 1);
  const Plane& fused = result.planes[0];
  EXPECT_EQ(fused.features.size(), scene.planes[0].features.size());
  EXPECT_EQ(fused.descriptors.rows(), static_cast<int>(fused.features.size()));
  for (const PlaneFeature& feature : fused.features) EXPECT_LT(feature.reference.x_px, 700);
}

TEST(FusePlanes, TheFeaturesOfBothAreKeptOnce) {
  SeenAgain scene(3);
  Surface more;  // the second look found these too
  more.Add(30, {100, 100}, {540, 380}, scene.random);
  Surface second = scene.wall;
  second.Add(more);
  scene.planes[2] = PlaneOf(3, 5, second, scene.h, scene.random);
  const FusionResult result = scene.Fuse({});
  ASSERT_EQ(result.fused, 1);
  const Plane& fused = result.planes[0];
  EXPECT_EQ(fused.features.size(), 130u);
  EXPECT_EQ(fused.descriptors.rows(), 130);
  int both = 0;
  for (int f = 0; f < fused.descriptors.rows(); ++f) {
    both += fused.features[f].votes == 6 && fused.features[f].visible == 8;
    const auto at = std::find_if(
        second.descriptors.begin(), second.descriptors.end(), [&](const auto& descriptor) {
          return std::equal(descriptor.begin(), descriptor.end(), fused.descriptors.row(f));
        });
    ASSERT_NE(at, second.descriptors.end());
    const Vector2d truth = second.points[at - second.descriptors.begin()];
    const Keypoint& k = fused.features[f].reference;
    EXPECT_LT((truth - Vector2d(k.x_px, k.y_px)).norm(), 2);
  }
  EXPECT_EQ(both, 100);
}

TEST(FusePlanes, EdgesPassToThePlaneThatStays) {
  // A' = A or PA or AP: 1 had 2, 3 had 4 and nothing else; 2 - 4 stays.
  const SeenAgain scene(4);
  const FusionResult result =
      scene.Fuse({EdgeBetween(1, 2), EdgeBetween(2, 4), EdgeBetween(3, 4, 1.5)});
  ASSERT_EQ(result.fused, 1);
  EXPECT_EQ(PairsOf(result.edges), (Pairs{{1, 2}, {1, 4}, {2, 4}}));
  EXPECT_EQ(result.edges[1].homology, EdgeBetween(3, 4, 1.5).homology);
  EXPECT_EQ(result.edges[1].third_eigenvalue, 1.5);
}

TEST(FusePlanes, AnEdgeOfBothIsThereOnce) {
  const SeenAgain scene(5);
  const FusionResult result = scene.Fuse({EdgeBetween(1, 4), EdgeBetween(2, 3), EdgeBetween(3, 4)});
  ASSERT_EQ(result.fused, 1);
  EXPECT_EQ(PairsOf(result.edges), (Pairs{{1, 2}, {1, 4}}));
}

TEST(FusePlanes, AnEdgeThatTurnsHasTheInverseHomology) {
  const SeenAgain scene(6);
  const Edge before = EdgeBetween(2, 3, 1.25);  // becomes 1 - 2
  const FusionResult result = scene.Fuse({before});
  ASSERT_EQ(result.edges.size(), 1u);
  EXPECT_EQ(PairsOf(result.edges), (Pairs{{1, 2}}));
  EXPECT_TRUE((result.edges[0].homology * before.homology).isIdentity(1e-12));
  EXPECT_NEAR(result.edges[0].third_eigenvalue, 0.8, 1e-12);
}

TEST(FusePlanes, PlanesSeenTogetherAreNotFused) {
  const SeenAgain scene(7);
  const FusionResult result = scene.Fuse({EdgeBetween(1, 3)});
  EXPECT_EQ(result.fused, 0);
  EXPECT_EQ(IdsOf(result.planes), (Ids{1, 2, 3, 4}));
  EXPECT_EQ(PairsOf(result.edges), (Pairs{{1, 3}}));
}

TEST(FusePlanes, APosterOnTwoWallsDoesNotMakeThemOne) {
  Random random(8);
  Surface poster;
  poster.Add(30, {250, 150}, {350, 300}, random);
  std::vector<Plane> planes;
  for (int id : {1, 2}) {
    Surface wall = RandomSurface(random, 150);
    wall.Add(poster);
    planes.push_back(PlaneOf(id, 3 * id, wall, Matrix3d::Identity(), random));
  }
  EXPECT_EQ(FusePlanes(planes, {}, Keyframes(10), kType, {}).fused, 0);
  PlaneLayerOptions careless;
  careless.fusion.min_overlap = 0;
  careless.fusion.max_moved_px = 1e6;  // a poster says little of where the wall's far end is
  EXPECT_EQ(FusePlanes(planes, {}, Keyframes(10), kType, careless).fused, 1)
      << "it is the overlap that tells them apart";
}

TEST(FusePlanes, TheSameSurfaceBeyondReachGetsAnEdge) {
  Random random(9);
  Surface wall;
  wall.Add(240, {0, 20}, {1100, 460}, random);
  Matrix3d shifted = Matrix3d::Identity();
  shifted(0, 2) = -400;
  const std::vector<Plane> planes = {PlaneOf(1, 1, wall, Matrix3d::Identity(), random),
                                     PlaneOf(2, 4, wall, shifted, random)};
  const FusionResult result = FusePlanes(planes, {}, Keyframes(10), kType, {});
  EXPECT_EQ(result.fused, 0);
  EXPECT_EQ(result.planes, planes);
  ASSERT_EQ(PairsOf(result.edges), (Pairs{{1, 2}}));
  EXPECT_EQ(result.edges[0].homology, Matrix3d::Identity());
  EXPECT_EQ(result.edges[0].third_eigenvalue, 1);
  EXPECT_EQ(result.edges[0].from, KeyframeId{1});
  EXPECT_EQ(result.edges[0].to, KeyframeId{4});
  PlaneLayerOptions far;
  far.max_extrapolation = 1;
  EXPECT_EQ(FusePlanes(planes, {}, Keyframes(10), kType, far).fused, 1);
}

// Where two looks share but a small part, the rest of the second lies within the first one's image
// and is still beyond what the matches determine.
TEST(FusePlanes, WhatFewCloseMatchesDontDetermineGetsAnEdge) {
  Random random(12);
  Surface shared;
  shared.Add(40, {40, 60}, {110, 130}, random);
  Surface first = shared;
  Surface second = shared;
  second.Add(100, {300, 60}, {600, 420}, random);
  const std::vector<Plane> planes = {PlaneOf(1, 1, first, Matrix3d::Identity(), random),
                                     PlaneOf(2, 4, second, MildHomography(random), random)};
  const FusionResult result = FusePlanes(planes, {}, Keyframes(10), kType, {});
  EXPECT_EQ(result.fused, 0);
  EXPECT_EQ(PairsOf(result.edges), (Pairs{{1, 2}}));
  PlaneLayerOptions careless;
  careless.fusion.max_moved_px = 1e6;
  careless.max_extrapolation = 10;
  EXPECT_EQ(FusePlanes(planes, {}, Keyframes(10), kType, careless).fused, 1)
      << "it is the noise that keeps them apart";
}

// As many looks at one surface as neighbours that are asked for: nothing is there by chance then.
TEST(FusePlanes, ASurfaceSeenOverAndOverBecomesOne) {
  Random random(13);
  const Surface wall = RandomSurface(random, 60);
  std::vector<Plane> planes;
  for (int i = 0; i < 20; ++i) {
    planes.push_back(PlaneOf(i + 1, 2 * i + 1, wall, MildHomography(random), random));
  }
  const FusionResult result = FusePlanes(planes, {}, Keyframes(64), kType, {});
  EXPECT_EQ(result.fused, 19);
  ASSERT_EQ(result.planes.size(), 1u);
  EXPECT_LE(result.planes[0].features.size(), 63u) << "points are there more than once";
}

TEST(FusePlanes, APlaneSeenThreeTimesBecomesOne) {
  SeenAgain scene(10);
  scene.planes[3] = PlaneOf(4, 8, scene.wall, MildHomography(scene.random), scene.random);
  const FusionResult result = scene.Fuse({EdgeBetween(2, 4)});
  EXPECT_EQ(result.fused, 2);
  EXPECT_EQ(IdsOf(result.planes), (Ids{1, 2}));
  EXPECT_EQ(result.planes[0].views.size(), 6u);
  EXPECT_EQ(result.planes[0].features.size(), 100u);
  EXPECT_EQ(PairsOf(result.edges), (Pairs{{1, 2}}));
}

TEST(FusePlanes, NothingToFuseIsFine) {
  const FusionResult none = FusePlanes({}, {}, {}, kType, {});
  EXPECT_TRUE(none.planes.empty());
  EXPECT_EQ(none.fused, 0);
  const SeenAgain scene(11);
  const std::vector<Plane> alone = {scene.planes[1]};
  EXPECT_EQ(FusePlanes(alone, {}, Keyframes(10), kType, {}).planes, alone);
}

// About thirty planes of twenty surfaces, some seen twice, with edges between neighbours.
struct RandomMap {
  std::vector<Plane> planes;
  std::vector<Edge> edges;
  std::set<std::pair<int64_t, int64_t>> same;  // pairs of planes of one surface
};

RandomMap MakeRandomMap(uint64_t seed) {
  constexpr int kSurfaces = 20;
  constexpr int kPlanes = 30;
  Random random(seed);
  std::vector<Surface> surfaces;
  for (int i = 0; i < kSurfaces; ++i) surfaces.push_back(RandomSurface(random, 60));
  RandomMap map;
  for (int i = 0; i < kPlanes; ++i) {
    // The first ten surfaces come again, in another order, as the last ten planes.
    const int surface = i < kSurfaces ? i : (7 * i) % 10;
    if (i >= kSurfaces) map.same.emplace(surface + 1, i + 1);
    map.planes.push_back(
        PlaneOf(i + 1, 2 * i + 1, surfaces[surface], MildHomography(random), random));
    if (i > 0) map.edges.push_back(EdgeBetween(i, i + 1));
  }
  return map;
}

TEST(ProposeFusions, NamesEveryPairThatIsOne) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const RandomMap map = MakeRandomMap(seed);
    const auto proposed = ProposeFusions(map.planes, map.edges, kType, {});
    std::set<std::pair<int64_t, int64_t>> pairs;
    for (size_t i = 0; i < proposed.size(); ++i) {
      EXPECT_LT(proposed[i].m, proposed[i].n);
      EXPECT_GE(proposed[i].votes, FusionOptions{}.min_votes);
      if (i > 0) {
        EXPECT_LE(proposed[i].votes, proposed[i - 1].votes);
      }
      pairs.emplace(proposed[i].m.value, proposed[i].n.value);
    }
    EXPECT_EQ(pairs.size(), proposed.size()) << "a pair is there twice";
    EXPECT_TRUE(std::includes(pairs.begin(), pairs.end(), map.same.begin(), map.same.end()));
    EXPECT_LT(pairs.size(), 2 * map.same.size()) << "most pairs are proposed by chance";
    for (size_t i = 0; i < map.same.size(); ++i) {
      EXPECT_TRUE(map.same.contains({proposed[i].m.value, proposed[i].n.value}))
          << "the most votes are for planes that are one";
    }
    for (const auto& pair : PairsOf(map.edges)) EXPECT_FALSE(pairs.contains(pair));
  }
}

TEST(ProposeFusions, NamesThemInALargeMapToo) {
  RandomMap map = MakeRandomMap(4);
  PlaneLayerOptions options;
  options.fusion.index.min_rows = 500;  // searched by lists then
  options.fusion.probes = 8;
  const auto proposed = ProposeFusions(map.planes, map.edges, kType, options.fusion);
  std::set<std::pair<int64_t, int64_t>> pairs;
  for (const FusionCandidate& c : proposed) pairs.emplace(c.m.value, c.n.value);
  EXPECT_TRUE(std::includes(pairs.begin(), pairs.end(), map.same.begin(), map.same.end()));
}

TEST(FusePlanes, FindsWhatTryingEveryPairFinds) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const RandomMap map = MakeRandomMap(seed);
    const auto keyframes = Keyframes(64);
    const FusionResult fast = FusePlanes(map.planes, map.edges, keyframes, kType, {});
    const FusionResult slow =
        FusePairs(map.planes, map.edges, keyframes, EveryPair(map.planes, map.edges), kType, {});
    EXPECT_EQ(fast.fused, static_cast<int>(map.same.size()));
    EXPECT_EQ(fast.fused, slow.fused);
    EXPECT_EQ(fast.planes, slow.planes);
    EXPECT_EQ(PairsOf(fast.edges), PairsOf(slow.edges));
    const Pairs pairs = PairsOf(fast.edges);
    EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
    for (const auto& [a, b] : pairs) EXPECT_LT(a, b);
  }
}

}  // namespace
}  // namespace waystone
