// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/outline.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/homography/homography.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Polygon = std::vector<Vector2d>;

double AreaOf(const Polygon& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& p = polygon[i];
    const Vector2d& q = polygon[(i + 1) % polygon.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return std::abs(twice) / 2;
}

Polygon Square(double x, double y, double side) {
  return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}

TEST(ClippedOutline, ASquareInsideStaysAsItIs) {
  const Polygon square = Square(10, 20, 50);
  EXPECT_EQ(ClippedOutline(square, Matrix3d::Identity(), {30, 30}, 640, 480), square);
}

TEST(ClippedOutline, IsMovedByTheHomography) {
  Matrix3d shift = Matrix3d::Identity();
  shift.col(2) << 100, 50, 1;
  EXPECT_EQ(ClippedOutline(Square(10, 20, 50), shift, {30, 30}, 640, 480), Square(110, 70, 50));
}

TEST(ClippedOutline, WhatIsOutsideIsCutOff) {
  const Polygon clipped =
      ClippedOutline(Square(-50, -50, 100), Matrix3d::Identity(), {10, 10}, 640, 480);
  EXPECT_NEAR(AreaOf(clipped), 50 * 50, 1e-9);
  // Pixels go from 0 to width - 1.
  const Polygon whole =
      ClippedOutline(Square(-1000, -1000, 3000), Matrix3d::Identity(), {10, 10}, 640, 480);
  EXPECT_NEAR(AreaOf(whole), 639 * 479, 1e-6);
  for (const Vector2d& x : whole) {
    EXPECT_TRUE(x.x() == 0 || x.x() == 639) << x.transpose();
    EXPECT_TRUE(x.y() == 0 || x.y() == 479) << x.transpose();
  }
}

// A U whose bottom is cut off: two legs, in one ring.
TEST(ClippedOutline, AConcaveOutlineKeepsItsArea) {
  const Polygon u = {{10, -50}, {110, -50}, {110, 40}, {80, 40},
                     {80, -20}, {40, -20},  {40, 40},  {10, 40}};
  const Polygon clipped = ClippedOutline(u, Matrix3d::Identity(), {20, 20}, 640, 480);
  EXPECT_NEAR(AreaOf(clipped), 2 * 30 * 40, 1e-9);
}

TEST(ClippedOutline, NothingIsLeftOfWhatIsWhollyOutside) {
  for (const Vector2d& corner :
       {Vector2d(-200, 10), Vector2d(700, 10), Vector2d(10, -200), Vector2d(10, 500)}) {
    const Polygon square = Square(corner.x(), corner.y(), 100);
    EXPECT_TRUE(
        ClippedOutline(square, Matrix3d::Identity(), corner + Vector2d(5, 5), 640, 480).empty());
  }
  EXPECT_TRUE(ClippedOutline({}, Matrix3d::Identity(), {0, 0}, 640, 480).empty());
}

// The horizon is x = 300 in the outline's frame: what lies beyond it is behind the camera.
TEST(ClippedOutline, WhatIsBehindTheHorizonIsCutOff) {
  Matrix3d h = Matrix3d::Identity();
  h.row(2) << -1.0 / 300, 0, 1;
  const Polygon outline = Square(100, 100, 400);
  const Polygon clipped = ClippedOutline(outline, h, {120, 120}, 640, 480);
  ASSERT_GE(clipped.size(), 3u);
  for (const Vector2d& x : clipped) {
    ASSERT_TRUE(x.allFinite());
    const Vector2d back = Apply(h.inverse(), x);
    EXPECT_LT(back.x(), 300);
    EXPECT_GE(back.x(), 100 - 1e-6);
    EXPECT_GE(x.x(), -1e-9);
    EXPECT_LE(x.x(), 639 + 1e-9);
  }
}

TEST(ClippedOutline, TheSignOfTheHomographyDoesNotMatter) {
  Matrix3d h = Matrix3d::Identity();
  h.row(2) << -1.0 / 300, 1e-4, 1;
  const Polygon plus = ClippedOutline(Square(100, 100, 400), h, {120, 120}, 640, 480);
  const Polygon minus = ClippedOutline(Square(100, 100, 400), -h, {120, 120}, 640, 480);
  ASSERT_EQ(plus.size(), minus.size());
  for (size_t i = 0; i < plus.size(); ++i) EXPECT_LT((plus[i] - minus[i]).norm(), 1e-9);
}

// Whatever comes in: finite, in the image, and every point of it is the image of one of the
// outline.
TEST(ClippedOutline, HoldsForRandomHomographies) {
  Random random(1);
  for (int trial = 0; trial < 500; ++trial) {
    Matrix3d h = Matrix3d::Identity();
    for (int k = 0; k < 8; ++k) {
      const double size = k / 3 == 2 ? 0.003 : k % 3 == 2 ? 200 : 0.5;
      h(k / 3, k % 3) += size * random.Normal();
    }
    if (std::abs(h.determinant()) < 0.05) continue;
    const Polygon outline = Square(100, 100, 300);
    const Vector2d inside(random.Uniform(100, 400), random.Uniform(100, 400));
    for (const Vector2d& x : ClippedOutline(outline, h, inside, 640, 480)) {
      ASSERT_TRUE(x.allFinite()) << "trial " << trial;
      EXPECT_GE(x.minCoeff(), -1e-6);
      EXPECT_LE(x.x(), 639 + 1e-6);
      EXPECT_LE(x.y(), 479 + 1e-6);
      const Vector2d back = Apply(h.inverse(), x);
      EXPECT_GE(back.minCoeff(), 100 - 1e-3) << "trial " << trial;
      EXPECT_LE(back.maxCoeff(), 400 + 1e-3) << "trial " << trial;
      EXPECT_TRUE(OnSameSide(h, back, inside)) << "trial " << trial;
    }
  }
}

}  // namespace
}  // namespace waystone
