// SPDX-License-Identifier: Apache-2.0
#include "core/homography/segment_planes.h"
#include "core/robust/median.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kOutlier = -1;

// Matches of two views with the plane that each belongs to.
struct Scene {
  MatchedPoints points;
  std::vector<int> truth;  // plane of a row, or kOutlier
  std::vector<Matrix3d> homographies;

  void AddPlane(const Matrix3d& b_from_a, int count, const Box& box, Random& random) {
    const PointPairs pairs = PairsOf(b_from_a, count, 0.4, random, box);
    for (int i = 0; i < count; ++i) {
      points.from.push_back(pairs.a[i]);
      points.to.push_back(pairs.b[i]);
      truth.push_back(static_cast<int>(homographies.size()));
    }
    homographies.push_back(b_from_a);
  }

  void AddOutliers(int count, Random& random) {
    for (int i = 0; i < count; ++i) {
      points.from.push_back(RandomPoint(random));
      points.to.push_back(RandomPoint(random));
      truth.push_back(kOutlier);
    }
  }

  std::vector<int> RowsOf(int plane) const {
    std::vector<int> rows;
    for (int row = 0; row < points.size(); ++row) {
      if (truth[row] == plane) rows.push_back(row);
    }
    return rows;
  }

  PlaneSegment Segment(int plane, int first, int count) const {
    std::vector<int> rows = RowsOf(plane);
    rows = {rows.begin() + first, rows.begin() + first + count};
    const PointPairs pairs = PointPairs{points.from, points.to}.Subset(rows);
    return {*RefineHomography(pairs, Normalised(homographies[plane])), rows};
  }
};

// The end of a corridor: a wall at the left, one in front, the floor; after a random motion.
Scene AnyCorridorScene(Random& random) {
  MadeViews views = RandomViews(random);
  views.t = Eigen::Vector3d(random.Uniform(-0.4, 0.4), random.Uniform(-0.3, 0.3), 0.5);
  Scene scene;
  scene.AddPlane(views.HomographyOf({Eigen::Vector3d(-1, 0, 0.05).normalized(), 1.5}), 100,
                 {0, 0, 200, 480}, random);
  scene.AddPlane(views.HomographyOf({Eigen::Vector3d(0, 0, 1), 5}), 100, {210, 0, 430, 240},
                 random);
  scene.AddPlane(views.HomographyOf({Eigen::Vector3d(0, 1, 0.05).normalized(), 1.2}), 100,
                 {210, 320, 430, 160}, random);
  scene.AddOutliers(130, random);  // 30 % of all
  return scene;
}

// Whether a match fits another plane than its own too, so that nobody can tell whose it is.
bool FitsAnother(const Scene& scene, int row) {
  constexpr double kTooNear_px = 6;
  for (int p = 0; p < static_cast<int>(scene.homographies.size()); ++p) {
    const Vector2d mapped = Apply(scene.homographies[p], scene.points.from[row]);
    if (p != scene.truth[row] && (mapped - scene.points.to[row]).norm() < kTooNear_px) return true;
  }
  return false;
}

// A corridor seen after a motion that shows its planes apart: in each, at most a tenth of the
// matches fits another one as well.
Scene CorridorScene(uint64_t seed) {
  Random random(seed);
  for (;;) {
    Scene scene = AnyCorridorScene(random);
    bool apart = true;
    for (int plane : {0, 1, 2}) {
      const std::vector<int> rows = scene.RowsOf(plane);
      apart = apart && std::count_if(rows.begin(), rows.end(), [&](int row) {
                         return FitsAnother(scene, row);
                       }) <= static_cast<int>(rows.size()) / 10;
    }
    if (apart) return scene;
  }
}

// Number of the found plane of each row, or kOutlier; also checks that rows are unique and sorted.
std::vector<int> LabelsOf(const Segmentation& segmentation, int rows) {
  std::vector<int> labels(rows, kOutlier);
  for (int p = 0; p < static_cast<int>(segmentation.planes.size()); ++p) {
    const std::vector<int>& of_plane = segmentation.planes[p].rows;
    EXPECT_TRUE(std::is_sorted(of_plane.begin(), of_plane.end()));
    for (int row : of_plane) {
      EXPECT_EQ(labels[row], kOutlier) << "row " << row << " belongs to two planes";
      labels[row] = p;
    }
  }
  return labels;
}

// The true plane that most rows of a segment belong to.
int MajorityOf(const PlaneSegment& segment, const Scene& scene) {
  std::map<int, int> counts;
  for (int row : segment.rows) ++counts[scene.truth[row]];
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

void ExpectSameSegmentation(const Segmentation& a, const Segmentation& b) {
  ASSERT_EQ(a.planes.size(), b.planes.size());
  for (size_t p = 0; p < a.planes.size(); ++p) {
    EXPECT_EQ(a.planes[p].rows, b.planes[p].rows);
    EXPECT_EQ(a.planes[p].to_from.b_from_a, b.planes[p].to_from.b_from_a);
  }
  EXPECT_EQ(a.rejected, b.rejected);
  EXPECT_EQ(a.merged, b.merged);
}

TEST(SegmentPlanes, FindsThreePlanesAmongThirtyPercentOutliers) {
  double wrong = 0;
  double all = 0;
  int spurious = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = CorridorScene(seed);
    const Segmentation found = SegmentPlanes(scene.points, {}, {}, seed);
    const std::vector<int> labels = LabelsOf(found, scene.points.size());
    std::set<int> true_planes;
    std::vector<int> majority;
    for (const PlaneSegment& segment : found.planes) {
      majority.push_back(MajorityOf(segment, scene));
      true_planes.insert(majority.back());
    }
    for (int plane : {0, 1, 2}) {
      EXPECT_TRUE(true_planes.contains(plane)) << "plane " << plane << ", seed " << seed;
    }
    spurious += static_cast<int>(found.planes.size()) - 3;
    for (int row = 0; row < scene.points.size(); ++row) {
      const int given = labels[row] == kOutlier ? kOutlier : majority[labels[row]];
      wrong += given != scene.truth[row];
      ++all;
    }
  }
  EXPECT_LT(wrong / all, 0.05);
  EXPECT_LE(spurious, 1) << "planes that are not there, over 20 scenes";
}

TEST(SegmentPlanes, ItsHomographiesAreThoseOfThePlanes) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = CorridorScene(seed);
    for (const PlaneSegment& segment : SegmentPlanes(scene.points, {}, {}, seed).planes) {
      const int plane = MajorityOf(segment, scene);
      if (plane == kOutlier) continue;
      std::vector<double> errors;
      for (int row : scene.RowsOf(plane)) {
        const Vector2d& x = scene.points.from[row];
        errors.push_back(
            (Apply(segment.to_from.b_from_a, x) - Apply(scene.homographies[plane], x)).norm());
      }
      EXPECT_LT(Median(errors), 1.0) << "plane " << plane << ", seed " << seed;
    }
  }
}

TEST(SegmentPlanes, IsDeterministicForASeed) {
  const Scene scene = CorridorScene(3);
  ExpectSameSegmentation(SegmentPlanes(scene.points, {}, {}, 5),
                         SegmentPlanes(scene.points, {}, {}, 5));
}

TEST(SegmentPlanes, EveryPlaneHasAtLeastMinInliers) {
  SegmentationOptions options;
  options.min_inliers = 40;
  const Scene scene = CorridorScene(4);
  const Segmentation found = SegmentPlanes(scene.points, {}, options, 1);
  EXPECT_FALSE(found.planes.empty());
  for (const PlaneSegment& segment : found.planes) EXPECT_GE(segment.rows.size(), 40u);
}

TEST(SegmentPlanes, MaxPlanesBoundsTheSearch) {
  SegmentationOptions options;
  options.max_planes = 2;
  EXPECT_LE(SegmentPlanes(CorridorScene(5).points, {}, options, 1).planes.size(), 2u);
}

TEST(SegmentPlanes, KnownPlanesComeFirstInTheirOrderAndGrow) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = CorridorScene(seed);
    const std::vector<PlaneSegment> known = {scene.Segment(2, 0, 50), scene.Segment(0, 0, 50)};
    const Segmentation found = SegmentPlanes(scene.points, known, {}, seed);
    LabelsOf(found, scene.points.size());
    ASSERT_GE(found.planes.size(), 3u) << "seed " << seed;
    EXPECT_EQ(MajorityOf(found.planes[0], scene), 2);
    EXPECT_EQ(MajorityOf(found.planes[1], scene), 0);
    EXPECT_EQ(MajorityOf(found.planes[2], scene), 1) << "the new one, seed " << seed;
    for (int p : {0, 1}) {
      EXPECT_GE(found.planes[p].rows.size(), 85u) << "known " << p << " didn't grow, seed " << seed;
      EXPECT_TRUE(std::includes(found.planes[p].rows.begin(), found.planes[p].rows.end(),
                                known[p].rows.begin(), known[p].rows.end()));
    }
  }
}

TEST(SegmentPlanes, AKnownPlaneNeverDisappears) {
  Random random(6);
  Scene scene = CorridorScene(6);
  PlaneSegment elsewhere;  // tracked here, but no match fits it any more
  elsewhere.to_from.b_from_a(0, 2) = 5000;
  const Segmentation found = SegmentPlanes(scene.points, {elsewhere}, {}, 1);
  ASSERT_FALSE(found.planes.empty());
  EXPECT_TRUE(found.planes[0].rows.empty());
  EXPECT_EQ(found.planes[0].to_from.b_from_a, elsewhere.to_from.b_from_a);
}

// One wall in two parts with a gap between, the smaller one known. Its homography is uncertain so
// far away that the other part comes up as a candidate; it is the same plane, or, where nobody can
// tell, a whole plane of its own.
TEST(SegmentPlanes, ASecondPartOfAPlaneIsMerged) {
  int together = 0;
  int merged = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    MadeViews views = RandomViews(random);
    views.t = Eigen::Vector3d(0.5, 0.1, 0.1);
    Scene scene;
    const Matrix3d wall = views.HomographyOf({Eigen::Vector3d(0.1, 0, 1).normalized(), 3});
    scene.AddPlane(wall, 40, {20, 80, 200, 250}, random);
    scene.AddPlane(wall, 80, {350, 50, 290, 400}, random);
    scene.AddOutliers(20, random);
    const Segmentation found = SegmentPlanes(scene.points, {scene.Segment(0, 0, 40)}, {}, seed);
    ASSERT_FALSE(found.planes.empty());
    EXPECT_LE(found.planes.size(), 2u) << "seed " << seed;
    together += found.planes[0].rows.size() >= 110;
    merged += found.merged;
  }
  EXPECT_GE(together, 10) << "of 20";
  EXPECT_GE(merged, 3) << "of 20";
}

// One homography that was stretched over two planes is found out by a patch of one of them.
TEST(SegmentPlanes, AKnownPlaneStretchedOverAnotherLosesItsMatches) {
  int told_apart = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = CorridorScene(seed);
    PlaneSegment stretched = scene.Segment(0, 0, 60);
    const PlaneSegment other = scene.Segment(1, 0, 60);
    stretched.rows.insert(stretched.rows.end(), other.rows.begin(), other.rows.end());
    std::sort(stretched.rows.begin(), stretched.rows.end());
    const Segmentation found = SegmentPlanes(scene.points, {stretched}, {}, seed);
    const std::vector<int>& rows = found.planes[0].rows;
    const auto wrong =
        std::count_if(rows.begin(), rows.end(), [&](int row) { return scene.truth[row] == 1; });
    told_apart +=
        wrong <= 6 && std::any_of(found.planes.begin() + 1, found.planes.end(),
                                  [&](const auto& p) { return MajorityOf(p, scene) == 1; });
  }
  EXPECT_GE(told_apart, 9) << "of 10";
}

// Walls that meet at vertical edges: one homography often explains two of them almost as well.
TEST(SegmentPlanes, TellsWallsSideBySideApart) {
  constexpr int kWalls = 4;
  constexpr double kWidth_px = static_cast<double>(kMadeWidth) / kWalls;
  int told_apart = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    MadeViews views = RandomViews(random);
    const auto edge = [&](double column_px) -> Vector3d {
      return random.Uniform(3, 7) * (views.k.inverse() * Vector3d(column_px, kMadeHeight / 2.0, 1));
    };
    Scene scene;
    Vector3d left = edge(0);
    for (int wall = 0; wall < kWalls; ++wall) {
      const Vector3d right = edge((wall + 1) * kWidth_px);
      const Vector3d n = (right - left).cross(Vector3d::UnitY()).normalized();
      scene.AddPlane(views.HomographyOf({n, n.dot(left)}), 60,
                     {wall * kWidth_px, 0, kWidth_px, kMadeHeight}, random);
      left = right;
    }
    scene.AddOutliers(80, random);
    std::set<int> shown;
    for (const PlaneSegment& plane : SegmentPlanes(scene.points, {}, {}, seed).planes) {
      shown.insert(MajorityOf(plane, scene));
    }
    shown.erase(kOutlier);
    told_apart += static_cast<int>(shown.size());
  }
  EXPECT_GE(told_apart, 67) << "of 80";
}

// What moves by itself in the scene is no plane of it: its homology with the true ones is invalid.
TEST(SegmentPlanes, WhatMovesByItselfIsRejected) {
  int rejected = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Scene scene = CorridorScene(seed);
    Random random(100 + seed);
    const MadeViews other = RandomViews(random);
    scene.AddPlane(other.HomographyOf(RandomPlane(random)), 60, {250, 30, 200, 200}, random);
    const Segmentation found = SegmentPlanes(scene.points, {}, {}, seed);
    const bool taken = std::any_of(found.planes.begin(), found.planes.end(),
                                   [&](const auto& p) { return MajorityOf(p, scene) == 3; });
    rejected += !taken;
  }
  EXPECT_GE(rejected, 16) << "of 20";
}

// A homology says that one of two is no plane, not which: a true plane isn't given up because most
// of what is known moves by itself, as long as one plane agrees with it.
TEST(SegmentPlanes, OneValidHomologyIsEnough) {
  int kept = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Scene scene = CorridorScene(seed);
    Random random(200 + seed);
    for (const Box& box : {Box{250, 30, 90, 200}, Box{350, 30, 90, 200}, Box{450, 30, 90, 200}}) {
      scene.AddPlane(RandomViews(random).HomographyOf(RandomPlane(random)), 60, box, random);
    }
    std::vector<PlaneSegment> known = {scene.Segment(0, 0, 60)};
    for (const int moving : {3, 4, 5}) known.push_back(scene.Segment(moving, 0, 60));
    const Segmentation found = SegmentPlanes(scene.points, known, {}, seed);
    kept += std::any_of(found.planes.begin() + 4, found.planes.end(),
                        [&](const auto& p) { return MajorityOf(p, scene) == 2; });
  }
  EXPECT_GE(kept, 19) << "of 20";
}

TEST(SegmentPlanes, NothingAmongNoiseOrAmongNoMatches) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    Scene scene;
    scene.AddOutliers(200, random);
    EXPECT_TRUE(SegmentPlanes(scene.points, {}, {}, seed).planes.empty()) << "seed " << seed;
  }
  EXPECT_TRUE(SegmentPlanes({}, {}, {}, 1).planes.empty());
}

// The paper's extraction, kept for comparison: the same scenes, with more matches at wrong planes.
TEST(GreedySegmentation, FindsThreePlanesOneAfterTheOther) {
  SegmentationOptions greedy;
  greedy.greedy = true;
  int found_planes = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = CorridorScene(seed);
    const Segmentation found = SegmentPlanes(scene.points, {}, greedy, seed);
    LabelsOf(found, scene.points.size());
    std::set<int> true_planes;
    for (const PlaneSegment& segment : found.planes) {
      EXPECT_GE(static_cast<int>(segment.rows.size()), greedy.min_inliers);
      true_planes.insert(MajorityOf(segment, scene));
    }
    true_planes.erase(kOutlier);
    found_planes += static_cast<int>(true_planes.size());
  }
  EXPECT_GE(found_planes, 54) << "of 60";
}

TEST(GreedySegmentation, KnownPlanesComeFirstAndTakeTheMatchesThatSupportThem) {
  SegmentationOptions greedy;
  greedy.greedy = true;
  const Scene scene = CorridorScene(2);
  const PlaneSegment known = scene.Segment(1, 0, 20);
  const Segmentation found = SegmentPlanes(scene.points, {known, known}, greedy, 2);
  LabelsOf(found, scene.points.size());
  ASSERT_GE(found.planes.size(), 2U);
  EXPECT_EQ(found.planes[0].to_from.b_from_a, known.to_from.b_from_a);
  EXPECT_GT(found.planes[0].rows.size(), 40U);
  EXPECT_EQ(MajorityOf(found.planes[0], scene), 1);
}

TEST(SegmentPlanes, RefusesMatchesOfDifferentLengths) {
  MatchedPoints points;
  points.from.resize(3);
  points.to.resize(2);
  EXPECT_THROW(SegmentPlanes(points, {}, {}, 1), CheckFailure);
}

TEST(SegmentationOptions, OutOfTheirRangeAreRefused) {
  const auto expect_refused = [](auto change) {
    SegmentationOptions options;
    change(options);
    try {
      options.Check();
      ADD_FAILURE() << "an option out of its range was taken";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    }
  };
  expect_refused([](auto& o) { o.ransac.max_error_px = -1; });
  expect_refused([](auto& o) { o.homology.draws = 0; });
  expect_refused([](auto& o) { o.min_inliers = 4; });
  expect_refused([](auto& o) { o.max_planes = 0; });
  expect_refused([](auto& o) { o.patch = 4; });
  expect_refused([](auto& o) { o.labelling.companions = 0; });
  expect_refused([](auto& o) { o.labelling.min_sigma_px = 0; });
  expect_refused([](auto& o) { o.labelling.tail = 0; });
  expect_refused([](auto& o) { o.labelling.plane_cost = -1; });
  expect_refused([](auto& o) { o.labelling.min_sigmas = o.labelling.max_sigmas = 0.5; });
  expect_refused([](auto& o) { o.labelling.max_sigmas = o.labelling.min_sigmas - 1; });
  EXPECT_NO_THROW(SegmentationOptions{}.Check());
}

}  // namespace
}  // namespace waystone
