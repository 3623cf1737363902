// SPDX-License-Identifier: Apache-2.0
#include "core/robust/median.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"

namespace waystone {
namespace {

TEST(Median, IsTheMiddleOne) {
  EXPECT_EQ(Median(std::vector<int>{5}), 5);
  EXPECT_EQ(Median(std::vector<int>{9, 1, 4}), 4);
  EXPECT_EQ(Median(std::vector<double>{2, 2, 7, 2, 100}), 2);
}

TEST(Median, OfAnEvenNumberIsTheUpperOne) {
  EXPECT_EQ(Median(std::vector<int>{3, 1}), 3);
  EXPECT_EQ(Median(std::vector<float>{4, 3, 2, 1}), 3);
}

TEST(Median, OfNothingIsZero) { EXPECT_EQ(Median(std::vector<double>{}), 0); }

TEST(Median, OfErrorsInTwoCoordinatesGivesTheirSigma) {
  Random random(1);
  std::vector<double> errors;
  for (int i = 0; i < 20'000; ++i) errors.push_back(std::hypot(random.Normal(), random.Normal()));
  for (int i = 0; i < 1'000; ++i) errors.push_back(1e6);  // outliers
  EXPECT_NEAR(Median(errors) / kRayleighMedian, 1, 0.05);
}

}  // namespace
}  // namespace waystone
