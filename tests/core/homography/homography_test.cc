// SPDX-License-Identifier: Apache-2.0
#include "core/homography/homography.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Four = std::array<Vector2d, 4>;

constexpr double kMinHeight = 0.05;

std::optional<Matrix3d> FromFour(const Four& a, const Four& b, double min_height = kMinHeight) {
  return HomographyFromFour(a, b, min_height);
}

Four Moved(const Matrix3d& h, const Four& points) {
  return {Apply(h, points[0]), Apply(h, points[1]), Apply(h, points[2]), Apply(h, points[3])};
}

const Four kSquare = {Vector2d(100, 100), Vector2d(300, 100), Vector2d(300, 300),
                      Vector2d(100, 300)};

TEST(Apply, DividesByTheThirdCoordinate) {
  Matrix3d h;
  h << 2, 0, 10, 0, 3, 20, 0.001, 0, 1;
  const Vector2d y = Apply(h, {1000, 100});
  EXPECT_DOUBLE_EQ(y.x(), 2010.0 / 2);
  EXPECT_DOUBLE_EQ(y.y(), 320.0 / 2);
}

TEST(Apply, IsNotFiniteOnTheHorizon) {
  Matrix3d h = Matrix3d::Identity();
  h.row(2) << 0.5, 0, -1;
  EXPECT_FALSE(Apply(h, {2, 7}).allFinite());
}

TEST(Apply, FollowsProductsAndInverses) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3d g = RandomHomography(random);
    const Matrix3d h = RandomHomography(random);
    const Vector2d x = RandomPoint(random);
    EXPECT_LT((Apply(g * h, x) - Apply(g, Apply(h, x))).norm(), 1e-6);
    EXPECT_LT((Apply(h.inverse(), Apply(h, x)) - x).norm(), 1e-8);
    EXPECT_LT((Apply(-3.5 * h, x) - Apply(h, x)).norm(), 1e-9) << "scale matters";
  }
}

TEST(Normalised, HasAOneInTheCornerAndIsTheSameMapping) {
  Random random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3d h = RandomHomography(random) * random.Uniform(-50, 50);
    const Matrix3d normalised = Normalised(h);
    EXPECT_DOUBLE_EQ(normalised(2, 2), 1);
    EXPECT_TRUE(Normalised(normalised).isApprox(normalised, 1e-15));
    EXPECT_LT(LargestDifference(h, normalised), 1e-8);
  }
}

TEST(Normalised, HasUnitNormWhereTheCornerIsZero) {
  Matrix3d h;
  h << 1, 2, 3, 4, 5, 7, 0.1, 0.2, 0;
  const Matrix3d normalised = Normalised(h);
  EXPECT_NEAR(normalised.norm(), 1, 1e-15);
  EXPECT_EQ(normalised(2, 2), 0);
}

// A wall x = 1 in front of camera a, which looks along it, and b, which is 5 farther ahead.
TEST(IsInFront, TellsWhatACameraHasPassed) {
  Matrix3d ahead = Matrix3d::Identity();
  ahead(2, 0) = -5;
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(IsInFront(sign * ahead, {1 / 6.0, 0.1}));
    EXPECT_FALSE(IsInFront(sign * ahead, {1 / 4.0, 0.1}));
    EXPECT_TRUE(IsInFront(sign * Matrix3d::Identity(), {1 / 4.0, 0.1}));
  }
}

TEST(OnSameSide, ComparesWithTheHorizon) {
  Matrix3d h = Matrix3d::Identity();
  h.row(2) << -0.01, 0, 1;  // the horizon is x = 100
  EXPECT_TRUE(OnSameSide(h, {99, 5}, {0, 0}));
  EXPECT_FALSE(OnSameSide(h, {101, 5}, {0, 0}));
  EXPECT_TRUE(OnSameSide(h, {101, 5}, {500, -9}));
  EXPECT_FALSE(OnSameSide(h, {100, 5}, {0, 0})) << "on the horizon itself";
  EXPECT_TRUE(OnSameSide(-h, {99, 5}, {0, 0})) << "the sign of H means nothing";
}

TEST(SymmetricTransferError2, IsTheMeanOfBothSquares) {
  Matrix3d twice = Matrix3d::Identity();
  twice(2, 2) = 0.5;  // x -> 2 x
  const double error2 =
      SymmetricTransferError2(twice, twice.inverse(), Vector2d(10, 10), Vector2d(24, 20));
  EXPECT_DOUBLE_EQ(error2, (4.0 * 4.0 + 2.0 * 2.0) / 2);
}

TEST(PointPairs, SubsetTakesTheRowsInTheirOrder) {
  PointPairs pairs;
  for (int i = 0; i < 5; ++i) pairs.Add(Vector2d(i, 0), Vector2d(0, i));
  const PointPairs subset = pairs.Subset(std::vector<int>{3, 1, 3});
  ASSERT_EQ(subset.size(), 3);
  EXPECT_EQ(subset.a[0], Vector2d(3, 0));
  EXPECT_EQ(subset.b[1], Vector2d(0, 1));
  EXPECT_EQ(subset.b[2], Vector2d(0, 3));
}

TEST(HomographyFromFour, IsExactForFourPointsOfAPlane) {
  Random random(3);
  int found = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    Four a;
    for (Vector2d& x : a) x = RandomPoint(random);
    const auto h = FromFour(a, Moved(truth, a));
    if (!h) continue;
    ++found;
    EXPECT_DOUBLE_EQ((*h)(2, 2), 1);
    EXPECT_LT(LargestDifference(*h, truth), 1e-5) << "trial " << trial;
  }
  EXPECT_GT(found, 300) << "most random quadrilaterals are good enough";
}

TEST(HomographyFromFour, DoesNotDependOnTheOrderOfThePoints) {
  Random random(4);
  const Matrix3d truth = RandomHomography(random);
  for (const auto& order :
       std::vector<std::array<int, 4>>{{1, 2, 3, 0}, {2, 0, 3, 1}, {3, 2, 1, 0}}) {
    Four a;
    for (int i = 0; i < 4; ++i) a[i] = kSquare[order[i]];
    const auto h = FromFour(a, Moved(truth, a));
    ASSERT_TRUE(h);
    EXPECT_LT(LargestDifference(*h, truth), 1e-7);
  }
}

TEST(HomographyFromFour, TakesAConcaveQuadrilateral) {
  const Four a = {Vector2d(0, 0), Vector2d(200, 0), Vector2d(0, 200), Vector2d(50, 50)};
  Random random(5);
  const Matrix3d truth = RandomHomography(random);
  const auto h = FromFour(a, Moved(truth, a));
  ASSERT_TRUE(h);
  EXPECT_LT(LargestDifference(*h, truth), 1e-6);
}

TEST(HomographyFromFour, RefusesThreePointsInALineInEitherImage) {
  for (int i = 0; i < 4; ++i) {
    Four line = kSquare;
    line[i] = 0.5 * (line[(i + 1) % 4] + line[(i + 3) % 4]);  // between its two neighbours
    EXPECT_FALSE(FromFour(line, kSquare)) << i;
    EXPECT_FALSE(FromFour(kSquare, line)) << i;
    EXPECT_FALSE(FromFour(line, line, 0.0)) << i;
  }
}

TEST(HomographyFromFour, RefusesTrianglesAsLowAsAsked) {
  // The lowest triangle is (p0, p1, p2): height 6 over a longest side of 200.
  const Four low = {Vector2d(0, 0), Vector2d(100, 6), Vector2d(200, 0), Vector2d(100, 200)};
  EXPECT_FALSE(FromFour(low, low, 0.05));
  EXPECT_TRUE(FromFour(low, low, 0.02));
}

TEST(HomographyFromFour, RefusesCoincidentPoints) {
  Four twice = kSquare;
  twice[2] = twice[0];
  EXPECT_FALSE(FromFour(twice, kSquare, 0.0));
  EXPECT_FALSE(FromFour(kSquare, twice, 0.0));
  EXPECT_FALSE(FromFour(twice, twice, 0.0));
}

TEST(HomographyFromFour, RefusesWhatTurnsOver) {
  Four mirrored = kSquare;
  for (Vector2d& x : mirrored) x.x() = 400 - x.x();
  EXPECT_FALSE(FromFour(kSquare, mirrored)) << "the back of the plane";
  Four bow_tie = kSquare;
  std::swap(bow_tie[0], bow_tie[1]);
  EXPECT_FALSE(FromFour(kSquare, bow_tie)) << "the horizon cuts the square";
}

TEST(HomographyFromFour, TakesAHalfTurn) {
  Four turned;
  for (int i = 0; i < 4; ++i) turned[i] = kSquare[(i + 2) % 4];
  EXPECT_TRUE(FromFour(kSquare, turned));
}

TEST(HomographyByDlt, IsExactForPointsOfAPlane) {
  Random random(6);
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    const auto h = HomographyByDlt(PairsOf(truth, 4 + random.Below(40), 0, random));
    ASSERT_TRUE(h);
    EXPECT_DOUBLE_EQ((*h)(2, 2), 1);
    // Four random points may nearly be in a line.
    EXPECT_LT(LargestDifference(*h, truth), 1e-2) << "trial " << trial;
  }
}

TEST(HomographyByDlt, DoesNotDependOnWhereTheOriginIs) {
  Random random(7);
  const Matrix3d truth = RandomHomography(random);
  PointPairs pairs = PairsOf(truth, 30, 0.5, random);
  const auto here = HomographyByDlt(pairs);
  Matrix3d shift = Matrix3d::Identity();
  shift.col(2) << 5000, -3000, 1;
  for (Vector2d& x : pairs.a) x = Apply(shift, x);
  for (Vector2d& x : pairs.b) x = Apply(shift, x);
  const auto there = HomographyByDlt(pairs);
  ASSERT_TRUE(here && there);
  EXPECT_LT(LargestDifference(*here, shift.inverse() * *there * shift), 1e-5);
}

TEST(HomographyByDlt, NeedsFourPairs) {
  Random random(8);
  const Matrix3d truth = RandomHomography(random);
  for (int count = 0; count < 4; ++count) {
    EXPECT_FALSE(HomographyByDlt(PairsOf(truth, count, 0, random))) << count;
  }
}

TEST(HomographyByDlt, RefusesPointsInALineAndPointsThatCoincide) {
  PointPairs line;
  PointPairs one;
  for (int i = 0; i < 12; ++i) {
    line.Add(Vector2d(10 * i, 20 * i), Vector2d(30 * i, 5 * i));
    one.Add(Vector2d(7, 8), Vector2d(9, 10));
  }
  EXPECT_FALSE(HomographyByDlt(line));
  EXPECT_FALSE(HomographyByDlt(one));
}

}  // namespace
}  // namespace waystone
