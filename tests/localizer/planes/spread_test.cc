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

TEST(Spread, CoverageIsTheShareOfCellsWithAPoint) {
  EXPECT_EQ(ComputeCoverage({}, 640, 480), 0);
  EXPECT_EQ(ComputeCoverage({{0, 0}, {127.9, 95.9}}, 640, 480), 1 / 25.0);
  EXPECT_EQ(ComputeCoverage({{0, 0}, {128, 0}, {0, 96}, {639, 479}}, 640, 480), 4 / 25.0);
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
