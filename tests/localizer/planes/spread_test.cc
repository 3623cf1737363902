// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/spread.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace waystone
