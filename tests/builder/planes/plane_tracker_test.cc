// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/plane_tracker.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <set>

#include "builder/planes/plane_features.h"
#include "core/base/check.h"
#include "core/homography/homology.h"
#include "tests/builder/planes/made_scene.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kFrames = 8;

KeyframeId IdOf(int frame) { return KeyframeId{frame + 1}; }

// The wall that most of a plane's features belong to.
int WallOf(const MadeScene& scene, const Plane& plane) {
  std::map<int, int> counts;
  for (int f = 0; f < plane.descriptors.rows(); ++f) {
    const int point = scene.PointOf(plane.descriptors.row(f));
    ++counts[point < 0 ? -1 : scene.points()[point].wall];
  }
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

// Root mean square distance, over a wall's points in a keyframe, between where the view's
// homography and the true one put them in the reference image.
double ErrorOf(MadeScene& scene, int wall, const Matrix3d& reference_from_keyframe,
               const Isometry3d& reference, const Isometry3d& keyframe) {
  const Matrix3d truth = scene.HomographyOf(wall, keyframe, reference);
  const Features seen =
      scene.See(keyframe, 0, [&](int point) { return scene.points()[point].wall == wall; });
  double sum = 0;
  for (const Keypoint& k : seen.keypoints) {
    const Vector2d x(k.x_px, k.y_px);
    sum += (Apply(reference_from_keyframe, x) - Apply(truth, x)).squaredNorm();
  }
  return std::sqrt(sum / seen.size());
}

// Nine of ten points are found in each frame.
MadeScene::Detected MostOf(MadeScene& scene) {
  return [&scene](int) { return scene.random().Uniform() < 0.9; };
}

struct Tracked {
  std::vector<Plane> planes;
  std::vector<Edge> edges;
  TrackerReport report;
};

Tracked ResultOf(PlaneTracker& tracker) {
  tracker.Finish();
  return {tracker.planes(), tracker.edges(), tracker.report()};
}

Tracked TrackCorner(MadeScene& scene, const std::optional<Camera>& camera = std::nullopt) {
  PlaneTracker tracker({});
  for (int i = 0; i < kFrames; ++i) {
    tracker.AddKeyframe(IdOf(i), scene.See(PassingPose(i), 0.2, MostOf(scene)), i == 0, camera);
  }
  return ResultOf(tracker);
}

// The same points in two scenes, of which the second is seen from keyframe `moved` on.
Tracked TrackMoved(MadeScene& before, MadeScene& after, int moved) {
  EXPECT_EQ(before.points().back().descriptor, after.points().back().descriptor);
  PlaneTracker tracker({});
  for (int i = 0; i < kFrames; ++i) {
    MadeScene& scene = i < moved ? before : after;
    tracker.AddKeyframe(IdOf(i), scene.See(PassingPose(i)), i == 0, std::nullopt);
  }
  return ResultOf(tracker);
}

TEST(PlaneTracker, FollowsTwoWalls) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    MadeScene scene = CornerScene(seed);
    const Tracked found = TrackCorner(scene);
    ASSERT_EQ(found.planes.size(), 2u) << "seed " << seed;
    EXPECT_EQ(found.report.started, 2);
    EXPECT_EQ(found.report.dropped, 0);
    EXPECT_EQ(found.report.rotation_only, 0);
    std::set<int> walls;
    for (const Plane& plane : found.planes) {
      const int wall = WallOf(scene, plane);
      walls.insert(wall);
      EXPECT_EQ(plane.reference, IdOf(0));
      ASSERT_EQ(plane.views.size(), static_cast<size_t>(kFrames)) << "seed " << seed;
      for (int i = 0; i < kFrames; ++i) {
        const PlaneView& view = plane.views[i];
        EXPECT_EQ(view.keyframe, IdOf(i));
        EXPECT_GE(view.inliers, kPointsOfWall / 2);
        EXPECT_LT(
            ErrorOf(scene, wall, view.reference_from_keyframe, PassingPose(0), PassingPose(i)), 1.0)
            << "seed " << seed << ", wall " << wall << ", keyframe " << i;
      }
      EXPECT_EQ(plane.views[0].reference_from_keyframe, Matrix3d::Identity());
    }
    EXPECT_EQ(walls, (std::set<int>{0, 1}));
  }
}

TEST(PlaneTracker, AFeatureIsOnePointOfItsWallAndCountsItsVotes) {
  MadeScene scene = CornerScene(1);
  std::map<int, int> seen_of_point;
  PlaneTracker tracker({});
  for (int i = 0; i < kFrames; ++i) {
    const Features features = scene.See(PassingPose(i), 0.2, MostOf(scene));
    for (int k = 0; k < features.size(); ++k) {
      ++seen_of_point[scene.PointOf(features.descriptors.row(k))];
    }
    tracker.AddKeyframe(IdOf(i), features, i == 0, std::nullopt);
  }
  int exact = 0;
  int all = 0;
  int strangers = 0;
  const Tracked found = ResultOf(tracker);
  for (const Plane& plane : found.planes) {
    const int wall = WallOf(scene, plane);
    std::set<int> points;
    for (int f = 0; f < static_cast<int>(plane.features.size()); ++f) {
      const PlaneFeature& feature = plane.features[f];
      const int point = scene.PointOf(plane.descriptors.row(f));
      EXPECT_TRUE(points.insert(point).second) << "point " << point << " is there twice";
      EXPECT_LE(feature.votes, seen_of_point[point]);
      EXPECT_GE(feature.visible, feature.votes);
      EXPECT_LE(feature.visible, kFrames);
      exact += feature.votes == seen_of_point[point];
      strangers += scene.points()[point].wall != wall;
      ++all;
    }
    EXPECT_EQ(plane.descriptors.rows(), static_cast<int>(plane.features.size()));
  }
  EXPECT_GT(all, 2 * kPointsOfWall * 9 / 10);
  EXPECT_GT(exact, all / 2);
  EXPECT_LE(strangers, all / 50);
}

TEST(PlaneTracker, JoinsTheWallsByAHomologyWithADoubleEigenvalue) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    MadeScene scene = CornerScene(seed);
    const Tracked found = TrackCorner(scene);
    ASSERT_EQ(found.edges.size(), 1u) << "seed " << seed;
    const Edge& edge = found.edges[0];
    EXPECT_EQ(edge.a, PlaneId{1});
    EXPECT_EQ(edge.b, PlaneId{2});
    EXPECT_EQ(edge.from, IdOf(0));
    EXPECT_EQ(edge.to, IdOf(1));
    const HomologyEigenvalues eigenvalues = ComputeEigenvalues(edge.homology);
    EXPECT_NEAR(eigenvalues.scale, 1, 1e-6);
    EXPECT_LT(eigenvalues.split, 0.02) << "seed " << seed;
    EXPECT_NEAR(eigenvalues.third, edge.third_eigenvalue, 1e-6);
    EXPECT_GT(std::abs(edge.third_eigenvalue - 1), 0.01);
    // H^{ab} = (H^a)^-1 H^b, both from `to` to `from`.
    const int a = WallOf(scene, found.planes[0]);
    const Matrix3d h_a = scene.HomographyOf(a, PassingPose(1), PassingPose(0));
    const Matrix3d h_b = scene.HomographyOf(1 - a, PassingPose(1), PassingPose(0));
    for (const Vector2d& x : {Vector2d(150, 100), Vector2d(320, 240), Vector2d(500, 400)}) {
      EXPECT_LT((Apply(edge.homology, x) - Apply(h_a.inverse() * h_b, x)).norm(), 2.5);
    }
  }
}

TEST(PlaneTracker, TheCameraDoesNotMatterWhileItMoves) {
  MadeScene with = CornerScene(2);
  MadeScene without = CornerScene(2);
  EXPECT_EQ(TrackCorner(with, MadeCamera()).planes, TrackCorner(without).planes);
}

TEST(PlaneTracker, IsDeterministic) {
  MadeScene once = CornerScene(3);
  MadeScene again = CornerScene(3);
  const Tracked a = TrackCorner(once);
  const Tracked b = TrackCorner(again);
  EXPECT_EQ(a.planes, b.planes);
  EXPECT_EQ(a.edges, b.edges);
}

TEST(PlaneTracker, APlaneThatLeavesTheViewIsClosed) {
  constexpr int kLast = 3;  // keyframe that shows the second wall
  MadeScene scene = CornerScene(4);
  PlaneTracker tracker({});
  for (int i = 0; i < kFrames; ++i) {
    const auto detected = [&](int point) { return i <= kLast || scene.points()[point].wall == 0; };
    tracker.AddKeyframe(IdOf(i), scene.See(PassingPose(i), 0.2, detected), i == 0, std::nullopt);
    EXPECT_EQ(tracker.planes().size(), i <= kLast ? 0u : 1u) << "keyframe " << i;
  }
  EXPECT_EQ(tracker.planes()[0].views.back().keyframe, IdOf(kLast));
  EXPECT_EQ(WallOf(scene, tracker.planes()[0]), 1);
  tracker.Finish();
  EXPECT_EQ(tracker.planes().size(), 2u);
}

TEST(PlaneTracker, AFeatureSeenTooSeldomIsDiscarded) {
  constexpr int kRare = 10;  // every tenth point shows in the first two keyframes alone
  MadeScene scene = CornerScene(5);
  PlaneTracker tracker({});
  for (int i = 0; i < kFrames; ++i) {
    const auto detected = [&](int point) { return i < 2 || point % kRare != 0; };
    tracker.AddKeyframe(IdOf(i), scene.See(PassingPose(i), 0.2, detected), i == 0, std::nullopt);
  }
  const Tracked found = ResultOf(tracker);
  ASSERT_EQ(found.planes.size(), 2u);
  int kept = 0;
  for (const Plane& plane : found.planes) {
    for (int f = 0; f < static_cast<int>(plane.features.size()); ++f) {
      EXPECT_NE(scene.PointOf(plane.descriptors.row(f)) % kRare, 0);
      ++kept;
    }
  }
  EXPECT_GT(kept, 2 * kPointsOfWall * 8 / 10);
  EXPECT_GE(found.report.features_dropped, 2 * kPointsOfWall / kRare / 2);
}

// Points that seem to lie on the wall at first and then move off it; they would just have enough
// votes if moving off counted as not being seen.
TEST(PlaneTracker, AFeatureThatMovesOffItsPlaneLosesVotes) {
  constexpr int kMoving = 12;  // too few to be a plane
  constexpr int kOff = 5;      // the first keyframe that shows them off the wall
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const auto make = [&](double before) {  // the same points, the last ones so far before the wall
      MadeScene scene(seed);
      scene.AddWall({{-1.6, -1.3, 4}, {1.5, 0, 2}, {0, 2.6, 0}}, kPointsOfWall);
      scene.AddWall({{-1.6, -1.3, 4 - before}, {1.5, 0, 2}, {0, 2.6, 0}}, kMoving);
      return scene;
    };
    MadeScene on = make(0);
    MadeScene off = make(0.6);
    const Tracked found = TrackMoved(on, off, kOff);
    ASSERT_EQ(found.planes.size(), 1u) << "seed " << seed;
    const Plane& plane = found.planes[0];
    EXPECT_EQ(plane.views.size(), static_cast<size_t>(kFrames));
    for (int f = 0; f < static_cast<int>(plane.features.size()); ++f) {
      // What the plane grew by after they moved is another matter: keyframes too close to tell can
      // bring a point back as a new feature.
      if (plane.features[f].visible <= kFrames - kOff) continue;
      EXPECT_LT(on.PointOf(plane.descriptors.row(f)), kPointsOfWall)
          << "seed " << seed << ": " << plane.features[f].votes << " votes of "
          << plane.features[f].visible;
    }
    EXPECT_GT(plane.features.size(), kPointsOfWall * 9u / 10);
    EXPECT_GE(found.report.features_dropped, kMoving - 2);
  }
}

// Things at four depths seem to lie on one wall at first, as they do while the camera moves little.
TEST(PlaneTracker, APlaneThatItsMatchesContradictIsDropped) {
  constexpr int kLayers = 4;
  constexpr int kOff = 2;  // the first keyframe that shows them apart
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const auto make = [&](double apart) {  // the same points, the layers so far before each other
      MadeScene scene(seed);
      for (int layer = 0; layer < kLayers; ++layer) {
        scene.AddWall({{-1.6, -1.3, 4 - layer * apart}, {1.5, 0, 2}, {0, 2.6, 0}}, 60);
      }
      return scene;
    };
    MadeScene as_one = make(0);
    MadeScene apart = make(0.4);
    const Tracked found = TrackMoved(as_one, apart, kOff);
    EXPECT_EQ(found.report.dropped, 1) << "seed " << seed;
    std::set<int> layers;
    for (const Plane& plane : found.planes) {
      EXPECT_EQ(plane.reference, IdOf(kOff - 1)) << "seed " << seed;
      layers.insert(WallOf(apart, plane));
    }
    EXPECT_EQ(layers.size(), static_cast<size_t>(kLayers)) << "seed " << seed;
  }
}

// The middle wall of three is seen with each of the others, which are never seen together.
TEST(PlaneTracker, OnlyPlanesSeenTogetherAreJoined) {
  constexpr int kChange = 4;
  MadeScene scene(12);
  scene.AddWall({{-1.9, -1.3, 4}, {1.2, 0, 1}, {0, 2.6, 0}}, kPointsOfWall);
  scene.AddWall({{-0.6, -1.3, 4.5}, {1.2, 0, 0.8}, {0, 2.6, 0}}, kPointsOfWall);
  scene.AddWall({{0.7, -1.3, 5.4}, {1.2, 0, -1.6}, {0, 2.6, 0}}, kPointsOfWall);
  PlaneTracker tracker({});
  for (int i = 0; i < kFrames; ++i) {
    const auto detected = [&](int point) {
      const int wall = scene.points()[point].wall;
      return wall == 1 || wall == (i < kChange ? 0 : 2);
    };
    tracker.AddKeyframe(IdOf(i), scene.See(PassingPose(i), 0.2, detected), i == 0, std::nullopt);
  }
  const Tracked found = ResultOf(tracker);
  ASSERT_EQ(found.planes.size(), 3u);
  std::map<PlaneId, int> wall_of;
  for (const Plane& plane : found.planes) wall_of[plane.id] = WallOf(scene, plane);
  std::set<std::set<int>> joined;
  for (const Edge& edge : found.edges) {
    EXPECT_LT(edge.a, edge.b);
    EXPECT_EQ(edge.to.value, edge.from.value + 1);
    joined.insert({wall_of.at(edge.a), wall_of.at(edge.b)});
  }
  EXPECT_EQ(joined, (std::set<std::set<int>>{{0, 1}, {1, 2}}));
  EXPECT_EQ(found.edges.size(), 2u) << "a pair is joined once";
}

TEST(PlaneTracker, ANewStretchClosesAllPlanes) {
  MadeScene scene = CornerScene(6);
  PlaneTracker tracker({});
  for (int i = 0; i < kFrames; ++i) {
    const bool starts = i == 0 || i == kFrames / 2;
    tracker.AddKeyframe(IdOf(i), scene.See(PassingPose(i)), starts, std::nullopt);
    EXPECT_EQ(tracker.planes().size(), i < kFrames / 2 ? 0u : 2u) << "keyframe " << i;
  }
  const Tracked found = ResultOf(tracker);
  ASSERT_EQ(found.planes.size(), 4u);
  for (const Plane& plane : found.planes) {
    EXPECT_EQ(plane.views.size(), static_cast<size_t>(kFrames / 2));
    EXPECT_EQ(plane.reference, plane.id <= PlaneId{2} ? IdOf(0) : IdOf(kFrames / 2));
  }
  EXPECT_EQ(found.edges.size(), 2u) << "none over the break";
}

TEST(PlaneTracker, PureRotationStartsNoPlane) {
  for (const std::optional<Camera>& camera : {std::optional<Camera>(), {MadeCamera()}}) {
    MadeScene scene = CornerScene(7);
    PlaneTracker tracker({});
    for (int i = 0; i < 5; ++i) {
      const Features seen = scene.See(PoseAt(0, 0, 0, -0.1 + 0.05 * i));
      tracker.AddKeyframe(IdOf(i), seen, i == 0, camera);
    }
    const Tracked found = ResultOf(tracker);
    EXPECT_EQ(found.report.rotation_only, 4);
    EXPECT_EQ(found.report.started, 0);
    EXPECT_TRUE(found.planes.empty());
    EXPECT_TRUE(found.edges.empty());
  }
}

TEST(PlaneTracker, OpenPlanesSurviveARotation) {
  MadeScene scene = CornerScene(8);
  PlaneTracker tracker({});
  for (int i = 0; i < 6; ++i) {
    const bool still = i >= 3;  // from there on it turns on the spot
    const Isometry3d pose =
        still ? PoseAt(-0.3, 0, 0, 0.03 * (i - 2)) : PoseAt(-0.9 + 0.3 * i, 0, 0);
    tracker.AddKeyframe(IdOf(i), scene.See(pose), i == 0, std::nullopt);
  }
  const Tracked found = ResultOf(tracker);
  ASSERT_EQ(found.planes.size(), 2u);
  EXPECT_EQ(found.report.rotation_only, 3);
  for (const Plane& plane : found.planes) EXPECT_EQ(plane.views.size(), 6u);
}

// Features that are off their wall in every other image lose a vote each time, and win none while
// the camera turns on the spot.
TEST(PlaneTracker, AFeatureWithoutVotesIsDiscardedWhateverTheShare) {
  const auto make = [](double before) {  // the same points, the last ones so far before the wall
    MadeScene scene(1);
    scene.AddWall({{-1.6, -1.3, 4}, {3, 0, 0.5}, {0, 2.6, 0}}, kPointsOfWall);
    scene.AddWall({{-1.6, -1.3, 4 - before}, {3, 0, 0.5}, {0, 2.6, 0}}, 12);
    return scene;
  };
  MadeScene on = make(0);
  MadeScene off = make(0.6);
  PlaneLayerOptions options;
  options.min_vote_share = 0;
  PlaneTracker tracker(options);
  for (int i = 0; i < 6; ++i) {
    const Isometry3d pose =
        i < 2 ? PoseAt(-0.6 + 0.3 * i, 0, 0) : PoseAt(-0.3, 0, 0, 0.02 * (i - 1));
    MadeScene& scene = i >= 2 && i % 2 == 0 ? off : on;
    tracker.AddKeyframe(IdOf(i), scene.See(pose), i == 0, std::nullopt);
  }
  const Tracked found = ResultOf(tracker);
  EXPECT_EQ(found.report.rotation_only, 4);
  ASSERT_EQ(found.planes.size(), 1u);
  EXPECT_GT(found.planes[0].features.size(), 100u);
  for (const PlaneFeature& feature : found.planes[0].features) EXPECT_GE(feature.votes, 1);
}

// Where most of a plane's matches are features that its reference image doesn't show, it wants a
// newer one; under a rotation, which fits every plane, it waits for a motion.
TEST(PlaneTracker, PureRotationRenewsNoPlane) {
  MadeScene scene = CornerScene(8);
  PlaneTracker tracker({});
  std::vector<int> started;
  for (int i = 0; i < 5; ++i) {
    const bool still = i >= 3;  // from there on it turns on the spot
    const Isometry3d pose =
        still ? PoseAt(-0.3, 0, 0, 0.03 * (i - 2)) : PoseAt(-0.9 + 0.3 * i, 0, 0);
    const auto detected = [&](int point) {  // first the even ones, at last hardly any of them
      return i == 0 ? point % 2 == 0 : !still || point % 2 == 1 || point % 8 == 0;
    };
    tracker.AddKeyframe(IdOf(i), scene.See(pose, 0.2, detected), i == 0, std::nullopt);
    started.push_back(tracker.report().started);
  }
  EXPECT_EQ(tracker.report().rotation_only, 2);
  EXPECT_EQ(started, (std::vector<int>{0, 2, 2, 2, 2}));
}

// Along a wall much longer than an image is wide.
TEST(PlaneTracker, ALongWallGetsNewerReferenceImages) {
  MadeScene scene(9);
  scene.AddWall({{-4, -1.5, 4}, {20, 0, 2}, {0, 3, 0}}, 900);
  PlaneLayerOptions options;
  PlaneTracker tracker(options);
  constexpr int kLong = 24;
  const auto pose = [](int i) { return PoseAt(0.5 * i, 0, 0.04 * i); };
  for (int i = 0; i < kLong; ++i) {
    tracker.AddKeyframe(IdOf(i), scene.See(pose(i)), i == 0, std::nullopt);
  }
  const Tracked found = ResultOf(tracker);
  EXPECT_GT(found.planes.size(), 2u);
  EXPECT_LT(found.planes.size(), static_cast<size_t>(kLong));
  std::set<KeyframeId> covered;
  int features = 0;
  int far = 0;
  for (const Plane& plane : found.planes) {
    const Isometry3d reference = pose(static_cast<int>(plane.reference.value) - 1);
    for (const PlaneFeature& feature : plane.features) {
      EXPECT_TRUE(IsWithinReach({feature.reference.x_px, feature.reference.y_px}, 640, 480,
                                options.max_extrapolation));
    }
    for (int f = 0; f < static_cast<int>(plane.features.size()); ++f) {
      const MadePoint& point = scene.points()[scene.PointOf(plane.descriptors.row(f))];
      const auto truth = Project(MadeCamera(), reference.inverse() * point.x_world);
      ASSERT_TRUE(truth);
      const Keypoint& k = plane.features[f].reference;
      const double error = (*truth - Vector2d(k.x_px, k.y_px)).norm();
      EXPECT_LT(error, 6) << "plane " << plane.id.value;
      ++features;
      far += error > 2;
    }
    for (const PlaneView& view : plane.views) covered.insert(view.keyframe);
  }
  EXPECT_LE(far, features / 50) << "of " << features;
  EXPECT_EQ(covered.size(), static_cast<size_t>(kLong)) << "the wall is lost on the way";
  for (size_t p = 1; p < found.planes.size(); ++p) {
    const PlaneId id{static_cast<int64_t>(p) + 1};
    EXPECT_TRUE(std::any_of(found.edges.begin(), found.edges.end(),
                            [&](const Edge& edge) { return edge.b == id || edge.a == id; }))
        << "plane " << p + 1 << " isn't joined to the wall's other parts";
  }
}

TEST(PlaneTracker, FramesWithoutFeaturesGiveNothing) {
  PlaneTracker tracker({});
  const Features empty{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  MadeScene scene = CornerScene(10);
  for (int i = 0; i < 3; ++i) tracker.AddKeyframe(IdOf(i), empty, i == 0, std::nullopt);
  tracker.AddKeyframe(IdOf(3), scene.See(PassingPose(3)), false, std::nullopt);
  tracker.AddKeyframe(IdOf(4), empty, false, MadeCamera());
  EXPECT_TRUE(ResultOf(tracker).planes.empty());
}

TEST(PlaneTracker, RefusesIdsThatDoNotAscend) {
  PlaneTracker tracker({});
  MadeScene scene = CornerScene(11);
  tracker.AddKeyframe(KeyframeId{2}, scene.See(PassingPose(0)), true, std::nullopt);
  EXPECT_THROW(tracker.AddKeyframe(KeyframeId{2}, scene.See(PassingPose(1)), false, std::nullopt),
               CheckFailure);
}

}  // namespace
}  // namespace waystone
