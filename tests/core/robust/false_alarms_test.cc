// SPDX-License-Identifier: Apache-2.0
#include "core/robust/false_alarms.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.h"

namespace waystone {
namespace {

TEST(LogBinomial, CountsSubsets) {
  EXPECT_EQ(LogBinomial(5, 0), 0);
  EXPECT_NEAR(LogBinomial(5, 2), std::log(10.0), 1e-12);
  EXPECT_NEAR(LogBinomial(52, 5), std::log(2'598'960.0), 1e-9);
  EXPECT_NEAR(LogBinomial(400, 180), LogBinomial(400, 220), 1e-9);
}

TEST(LogFalseAlarms, IsTheExpectedNumberOfModels) {
  // (10 - 5) * 10 * C(10, 8) * C(8, 5) * 0.01^3
  EXPECT_NEAR(LogFalseAlarms(10, 8, 0.01, {.sample = 5, .solutions = 10}),
              std::log(5 * 10 * 45 * 56 * 1e-6), 1e-9);
  EXPECT_EQ(LogFalseAlarms(100, 5, 0.01, {.sample = 5}), 0) << "a sample always fits";
  EXPECT_EQ(LogFalseAlarms(4, 9, 0.01, {.sample = 5}), 0);
}

// The number of models with k inliers among unrelated points, counted over all samples, stays
// below its expectation: lines through two points of a square, points within a band.
TEST(LogFalseAlarms, BoundsTheModelsOfUnrelatedPoints) {
  constexpr int kPoints = 30;
  constexpr double kBand = 0.01;
  constexpr double kChance = 2 * kBand * 1.4143;  // the band's largest share of the square
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    std::vector<std::pair<double, double>> points;
    for (int i = 0; i < kPoints; ++i) points.emplace_back(random.Uniform(), random.Uniform());
    int most = 0;
    for (const auto& [x1, y1] : points) {
      for (const auto& [x2, y2] : points) {
        const double length = std::hypot(x2 - x1, y2 - y1);
        if (length == 0) continue;
        int inliers = 0;
        for (const auto& [x, y] : points) {
          const double off = ((x2 - x1) * (y - y1) - (y2 - y1) * (x - x1)) / length;
          inliers += std::abs(off) <= kBand ? 1 : 0;
        }
        most = std::max(most, inliers);
      }
    }
    EXPECT_GT(LogFalseAlarms(kPoints, most, kChance, {.sample = 2}), std::log(1e-3)) << seed;
  }
}

}  // namespace
}  // namespace waystone
