// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/plane_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/base/random.h"

namespace waystone {
namespace {

using Eigen::Vector3d;

const Vector3d kNormal = Vector3d(1, 2, -2) / 3;
constexpr double kDistance = 1.5;

// Points of the plane, known less well along a slanted ray; some lie elsewhere.
std::vector<UncertainPoint> PointsOfPlane(int count, int elsewhere, double rough, Random& random) {
  std::vector<UncertainPoint> points;
  const Vector3d across = kNormal.unitOrthogonal();
  for (int i = 0; i < count; ++i) {
    const Vector3d ray = (kNormal + 0.3 * across).normalized();
    UncertainPoint point{kDistance * kNormal + random.Uniform(-1, 1) * across +
                             random.Uniform(-1, 1) * kNormal.cross(across),
                         0.01 * ray, 0.001};
    point.x += random.Normal() * point.along +
               0.001 * Vector3d(random.Normal(), random.Normal(), random.Normal()) +
               rough * random.Normal() * kNormal;
    if (i < elsewhere) point.x += 0.3 * kNormal;
    points.push_back(point);
  }
  return points;
}

TEST(FitPlane, FindsThePlaneBesideOutliersAndStatesItsErrors) {
  Random random(1);
  double squares = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto plane = FitPlane(PointsOfPlane(60, 4, 0, random), 8);
    ASSERT_TRUE(plane);
    const double sign = plane->normal.dot(kNormal) > 0 ? 1 : -1;
    EXPECT_GT(sign * plane->normal.dot(kNormal), std::cos(0.02));
    EXPECT_GE(plane->inliers, 50);
    // The distance of a point in the middle of the others.
    Eigen::Vector4d gradient;
    const double off = plane->normal.dot(kDistance * kNormal) - plane->distance;
    gradient << kDistance * kNormal, -1;
    squares += off * off / gradient.dot(plane->covariance * gradient) / kTrials;
  }
  EXPECT_GT(squares, 0.4);
  EXPECT_LT(squares, 2);
}

TEST(FitPlane, MeasuresHowFlatASurfaceIs) {
  Random random(2);
  const auto flat = FitPlane(PointsOfPlane(200, 0, 0, random), 8);
  const auto rough = FitPlane(PointsOfPlane(200, 0, 0.05, random), 8);
  ASSERT_TRUE(flat && rough);
  EXPECT_LT(flat->flatness, 0.006);
  EXPECT_NEAR(rough->flatness, 0.05, 0.015);
}

TEST(FitPlane, FindsNoneInFewPointsOrALine) {
  Random random(3);
  EXPECT_FALSE(FitPlane(PointsOfPlane(7, 0, 0, random), 8));
  std::vector<UncertainPoint> line;
  for (int i = 0; i < 20; ++i) {
    line.push_back({Vector3d(i, 2 * i, 0), 0.001 * Vector3d::UnitZ(), 1e-6});
  }
  EXPECT_FALSE(FitPlane(line, 8));
}

}  // namespace
}  // namespace waystone
