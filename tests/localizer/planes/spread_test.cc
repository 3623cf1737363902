// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/spread.h"

#include <gtest/gtest.h>

#include <cmath>

namespace waystone {
namespace {

TEST(Spread, PointsNearOneCountedBeforeDontCount) {
  EXPECT_EQ(CountApart({}, 4), 0);
  EXPECT_EQ(CountApart({{10, 10}, {13, 10}, {10, 13.9}, {10, 14}}, 4), 2);
  EXPECT_EQ(CountApart({{10, 10}, {13, 10}, {16, 10}}, 4), 2) << "13 isn't counted, so 16 is";
  EXPECT_EQ(CountApart({{1, 1}, {1, 1}, {1, 1}}, 0), 3);
}

TEST(CountIndependent, FeaturesOfOneCornerCountOnce) {
  EXPECT_EQ(CountIndependent({}, FeatureType::kSift), 0);
  EXPECT_EQ(CountIndependent({{50, 50, 2}, {52, 51, 5}, {47, 50, 9}}, FeatureType::kSift), 1);
}

TEST(CountIndependent, TheDistanceIsInScales) {
  const auto count = [](FeatureType type, float x) {
    return CountIndependent({{50, 50, 20}, {x, 50, 40}}, type);
  };
  EXPECT_EQ(count(FeatureType::kSift, 229.9F), 1);
  EXPECT_EQ(count(FeatureType::kSift, 230.1F), 2) << "6 times the mean of 20 and 40";
  EXPECT_EQ(count(FeatureType::kOrb, 54.4F), 1);
  EXPECT_EQ(count(FeatureType::kOrb, 54.6F), 2);
  EXPECT_EQ(count(FeatureType::kAkaze, 94.9F), 1);
  EXPECT_EQ(count(FeatureType::kAkaze, 95.1F), 2);
}

TEST(CountIndependent, SmallOnesComeBeforeALargeOneThatCoversThem) {
  EXPECT_EQ(CountIndependent({{65, 50, 12}, {50, 50, 2}, {80, 50, 2}}, FeatureType::kSift), 2);
}

TEST(ComputeCoverage, IsTheShareOfTheImageNearAPoint) {
  constexpr double kDisc = 1 / 40.0;
  EXPECT_EQ(ComputeCoverage({}, 640, 480), 0);
  EXPECT_NEAR(ComputeCoverage({{320, 240}}, 640, 480), kDisc, 0.002);
  EXPECT_NEAR(ComputeCoverage({{240, 320}}, 480, 640), kDisc, 0.002) << "portrait";
  EXPECT_NEAR(ComputeCoverage({{0, 0}}, 640, 480), kDisc / 4, 0.002) << "the image ends there";
  EXPECT_NEAR(ComputeCoverage({{100, 100}, {300, 100}, {300, 300}}, 640, 480), 3 * kDisc, 0.004);
}

TEST(ComputeCoverage, ManyPointsInOneSpotCoverThatSpotWhereverItIs) {
  for (double x = 200; x < 264; x += 4) {
    const double coverage = ComputeCoverage({{x, 96}, {x + 6, 99}, {x + 3, 92}}, 640, 480);
    EXPECT_NEAR(coverage, 0.028, 0.004) << x;
  }
}

TEST(ComputeCoverage, IsAtMostOne) {
  std::vector<Eigen::Vector2d> points;
  for (int x = 0; x < 640; x += 20) {
    for (int y = 0; y < 480; y += 20) points.emplace_back(x, y);
  }
  EXPECT_EQ(ComputeCoverage(points, 640, 480), 1);
}

TEST(CanShow, WhatIsWellInsideAndNotClipped) {
  Features image{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  EXPECT_TRUE(CanShow(image, {32, 24}));
  EXPECT_TRUE(CanShow(image, {607.9, 455.9}));
  for (const Eigen::Vector2d& x :
       {Eigen::Vector2d(31.9, 240), {608, 240}, {320, 23.9}, {320, 456}}) {
    EXPECT_FALSE(CanShow(image, x)) << x.transpose();
  }
  EXPECT_FALSE(CanShow(image, Eigen::Vector2d::Constant(std::nan(""))));
  image.clipped.assign(kClippedCells * kClippedCells, false);
  image.clipped[kClippedCells * 16 + 8] = true;
  EXPECT_FALSE(CanShow(image, {165, 245}));
  EXPECT_TRUE(CanShow(image, {185, 245}));
}

}  // namespace
}  // namespace waystone
