// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/one_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "schema/layers/planes/surfaces.h"
#include "tests/builder/planes/made_surface.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The homography between keyframes i steps apart of a plane n . X = d, for a camera of focal length
// 500 px that moves 0.1 sideways and 0.05 ahead a step.
Matrix3d Moved(int steps, const Vector3d& normal, double distance) {
  Matrix3d camera;
  camera << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  const Vector3d motion(-0.1 * steps, 0, -0.05 * steps);
  return camera * (Matrix3d::Identity() + motion * normal.transpose() / distance) *
         camera.inverse();
}

// A plane with features in a part of its reference image, keyframe 1, seen by `views` keyframes.
Plane Part(int id, double left, double right, const Vector3d& normal, double distance, int views) {
  Plane plane;
  plane.id = PlaneId{id};
  plane.reference = KeyframeId{1};
  for (int i = 0; i < 40; ++i) {
    const auto x = static_cast<float>(left + (right - left) * (i % 8) / 7);
    const int row = i / 8;
    const auto y = static_cast<float>(60 + 80 * row);
    plane.features.push_back({{x, y, 6, 0}, 2, 2});
  }
  for (int k = 0; k < views; ++k) {
    plane.views.push_back({KeyframeId{k + 1}, Moved(k, normal, distance).inverse(), 40});
  }
  return plane;
}

const Vector3d kFacing = Vector3d::UnitZ();
constexpr double kApart_px = 2;

TEST(LieOnOneSurface, PartsOfOneWallDo) {
  const Plane left = Part(1, 20, 250, kFacing, 4, 4);
  const Plane right = Part(2, 350, 600, kFacing, 4, 4);
  EXPECT_TRUE(LieOnOneSurface(left, right, Keyframes(4), kApart_px));
}

TEST(LieOnOneSurface, ThePictureBeforeAWallDoesNot) {
  const Plane wall = Part(1, 20, 250, kFacing, 4, 4);
  EXPECT_FALSE(LieOnOneSurface(wall, Part(2, 350, 600, kFacing, 3.5, 4), Keyframes(4), kApart_px));
}

TEST(LieOnOneSurface, TwoWallsOfACornerDoNot) {
  const Plane wall = Part(1, 20, 250, kFacing, 4, 4);
  const Vector3d aside = Vector3d(0.5, 0, 1).normalized();
  EXPECT_FALSE(LieOnOneSurface(wall, Part(2, 350, 600, aside, 4, 4), Keyframes(4), kApart_px));
}

// What two keyframes near each other can't tell, two far apart can.
TEST(LieOnOneSurface, TheWidestPairDecides) {
  const double behind = 4.2;
  EXPECT_TRUE(LieOnOneSurface(Part(1, 20, 250, kFacing, 4, 2),
                              Part(2, 350, 600, kFacing, behind, 2), Keyframes(2), kApart_px));
  EXPECT_FALSE(LieOnOneSurface(Part(1, 20, 250, kFacing, 4, 6),
                               Part(2, 350, 600, kFacing, behind, 6), Keyframes(6), kApart_px));
}

// Homographies that agree where both keyframes show the planes don't agree behind the camera.
TEST(LieOnOneSurface, FeaturesBehindTheCameraDoNotDecide) {
  const auto plane_at = [](int id, const std::vector<std::pair<double, double>>& spans) {
    Plane plane;
    plane.id = PlaneId{id};
    plane.reference = KeyframeId{1};
    for (const auto& [left, right] : spans) {
      const Plane part = Part(id, left, right, kFacing, 4, 0);
      plane.features.insert(plane.features.end(), part.features.begin(), part.features.end());
    }
    for (PlaneFeature& feature : plane.features) feature.reference.y_px /= 20;
    return plane;
  };
  // Features right of x = 100 are behind the camera, and to the left of the others in its image.
  const Matrix3d from_reference{{1 - 3.1667, 0, 316.67}, {-1, 1, 100}, {-0.01, 0, 1}};
  const Matrix3d stretched{{1.02, 0, -8}, {0, 1, 0}, {0, 0, 1}};  // by 5 px there
  Plane m = plane_at(1, {{20, 60}, {240, 260}, {240, 260}});
  Plane n = plane_at(2, {{20, 60}});
  for (Plane* plane : {&m, &n}) {
    plane->views.push_back({KeyframeId{1}, from_reference.inverse(), 40});
    plane->views.push_back({KeyframeId{2}, from_reference.inverse(), 40});
  }
  n.views[1].reference_from_keyframe = (stretched * from_reference).inverse();
  EXPECT_TRUE(LieOnOneSurface(m, n, Keyframes(2), kApart_px));
}

TEST(LieOnOneSurface, PlanesThatWereNotSeenTogetherCannotBeTold) {
  const Plane one = Part(1, 20, 250, kFacing, 4, 4);
  Plane other = Part(2, 350, 600, kFacing, 4, 4);
  for (PlaneView& view : other.views) view.keyframe.value += 4;
  EXPECT_FALSE(LieOnOneSurface(one, other, Keyframes(8), kApart_px));
  other.views.front().keyframe = KeyframeId{4};  // one keyframe of both: nothing moves
  EXPECT_FALSE(LieOnOneSurface(one, other, Keyframes(8), kApart_px));
}

TEST(JoinSurfaces, OnlyEdgesBetweenPartsOfOneSurfaceBecomeTheIdentity) {
  const std::vector<Plane> planes = {Part(1, 20, 250, kFacing, 4, 4),
                                     Part(2, 350, 600, kFacing, 4, 4),
                                     Part(3, 350, 600, kFacing, 3, 4)};
  const Matrix3d measured = Vector3d(1, 1, 1.2).asDiagonal();
  std::vector<Edge> edges;
  for (const auto& [a, b] : {std::pair{1, 2}, {1, 3}, {2, 3}}) {
    edges.push_back({PlaneId{a}, PlaneId{b}, KeyframeId{1}, KeyframeId{2}, measured, 1.2});
  }
  JoinSurfaces(planes, Keyframes(4), kApart_px, edges);
  EXPECT_TRUE(JoinsOneSurface(edges[0]));
  EXPECT_EQ(edges[0].third_eigenvalue, 1);
  EXPECT_EQ(edges[1].homology, measured);
  EXPECT_EQ(edges[2].homology, measured);
  EXPECT_EQ(FindSurfaces(planes, edges), (std::vector{PlaneId{1}, PlaneId{1}, PlaneId{3}}));
  EXPECT_EQ(CountSurfaces(FindSurfaces(planes, edges)), 2);
}

TEST(FindSurfaces, GoByTheLowestIdWhateverTheOrder) {
  std::vector<Plane> planes;
  for (const int id : {5, 3, 9, 4}) {
    planes.emplace_back();
    planes.back().id = PlaneId{id};
  }
  std::vector<Edge> edges = {{PlaneId{5}, PlaneId{9}, KeyframeId{1}, KeyframeId{2}},
                             {PlaneId{4}, PlaneId{9}, KeyframeId{1}, KeyframeId{2}}};
  EXPECT_EQ(FindSurfaces(planes, edges),
            (std::vector{PlaneId{4}, PlaneId{3}, PlaneId{4}, PlaneId{4}}));
  EXPECT_TRUE(FindSurfaces({}, {}).empty());
}

}  // namespace
}  // namespace waystone
