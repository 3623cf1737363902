// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/spread.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace waystone {
namespace {

TEST(Spread, PointsNearOneCountedBeforeDontCount) {
  EXPECT_EQ(CountApart({}, 4), 0);
  EXPECT_EQ(CountApart({{10, 10}, {13, 10}, {10, 13.9}, {10, 14}}, 4), 2);
  EXPECT_EQ(CountApart({{10, 10}, {13, 10}, {16, 10}}, 4), 2) << "13 isn't counted, so 16 is";
  EXPECT_EQ(CountApart({{1, 1}, {1, 1}, {1, 1}}, 0), 3);
}

// Features at those positions, with those sizes.
Features FeaturesAt(FeatureType type, const std::vector<Keypoint>& keypoints) {
  Features features;
  features.type = type;
  features.keypoints = keypoints;
  return features;
}

int CountAll(const Features& features) {
  std::vector<int> all(features.size());
  std::iota(all.begin(), all.end(), 0);
  return CountIndependent(features, all);
}

TEST(CountIndependent, FeaturesOfOneCornerCountOnce) {
  EXPECT_EQ(CountAll({}), 0);
  EXPECT_EQ(CountAll(FeaturesAt(FeatureType::kSift, {{50, 50, 2}, {52, 51, 5}, {47, 50, 9}})), 1);
}

TEST(CountIndependent, WindowsMayTouch) {
  const auto count = [](double x) {
    return CountAll(FeaturesAt(FeatureType::kSift, {{50, 50, 2}, {static_cast<float>(x), 50, 4}}));
  };
  EXPECT_EQ(count(67.9), 1);
  EXPECT_EQ(count(68), 2) << "6 of the one and 12 of the other";
}

TEST(CountIndependent, SmallOnesComeBeforeALargeOneThatCoversThem) {
  EXPECT_EQ(CountAll(FeaturesAt(FeatureType::kSift, {{65, 50, 12}, {50, 50, 2}, {80, 50, 2}})), 2);
}

TEST(CountIndependent, CountsThoseThatAreNamed) {
  const Features image = FeaturesAt(FeatureType::kSift, {{50, 50, 2}, {150, 50, 2}, {250, 50, 2}});
  EXPECT_EQ(CountIndependent(image, std::vector{0, 2}), 2);
  EXPECT_EQ(CountIndependent(image, std::vector{1, 1}), 1);
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
    for (int y = 0; y < 480; y += 20) points.push_back(Eigen::Vector2d(x, y));
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
