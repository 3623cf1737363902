// SPDX-License-Identifier: Apache-2.0
#include "core/base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace waystone {
namespace {

TEST(Random, IsTheMersenneTwisterOfTheStandard) {
  Random random(5489);  // the engine's default seed
  EXPECT_EQ(random.Next(), 14514284786278117030u);
  for (int i = 2; i < 10000; ++i) random.Next();
  EXPECT_EQ(random.Next(), 9981545732273789042u);  // [rand.predef]: the 10,000th number
}

// A map depends on these numbers: a change here changes what every seed builds.
TEST(Random, DerivedNumbersArePinned) {
  Random random(5489);
  EXPECT_EQ(random.Below(1000), 786);                            // 14514284786278117030 / 2^64
  EXPECT_DOUBLE_EQ(random.Uniform(), 0.2504803406880286);        // 4620546740167642908 / 2^64
  EXPECT_DOUBLE_EQ(random.Uniform(-1, 1), 0.42134245795731085);  // 13109570281517897720 / 2^64
}

TEST(Random, ASeedGivesItsSequenceAgainAndAnotherSeedAnother) {
  Random a(7);
  Random b(7);
  Random c(8);
  int equal = 0;
  for (int i = 0; i < 1000; ++i) {
    const uint64_t x = a.Next();
    EXPECT_EQ(x, b.Next());
    equal += x == c.Next();
  }
  EXPECT_EQ(equal, 0);
}

TEST(Random, BelowStaysInItsRangeAndFillsItEvenly) {
  Random random(1);
  for (int n : {1, 2, 3, 7, 10, 1000}) {
    std::vector<int> counts(n, 0);
    const int draws = 1000 * n;
    for (int i = 0; i < draws; ++i) {
      const int x = random.Below(n);
      ASSERT_GE(x, 0);
      ASSERT_LT(x, n);
      ++counts[x];
    }
    // 1000 +- 32 a number; seven of those sigmas never happen by chance.
    for (int count : counts) EXPECT_NEAR(count, 1000, n == 1 ? 0 : 225) << "of " << n;
  }
}

TEST(Random, BelowTakesTheLargestInt) {
  Random random(2);
  constexpr int kLargest = std::numeric_limits<int>::max();
  int largest = 0;
  for (int i = 0; i < 1000; ++i) {
    const int x = random.Below(kLargest);
    ASSERT_GE(x, 0);
    ASSERT_LT(x, kLargest);
    largest = std::max(largest, x);
  }
  EXPECT_GT(largest, kLargest / 100 * 98);
}

TEST(Random, UniformStaysInItsRangeWithItsMeanAndVariance) {
  Random random(3);
  constexpr int kDraws = 100000;
  double sum = 0;
  double sum2 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.Uniform(2, 5);
    ASSERT_GE(x, 2);
    ASSERT_LT(x, 5);
    sum += x;
    sum2 += x * x;
  }
  const double mean = sum / kDraws;
  EXPECT_NEAR(mean, 3.5, 0.02);
  EXPECT_NEAR(sum2 / kDraws - mean * mean, 9.0 / 12, 0.02);
}

TEST(Random, NormalHasTheMomentsOfAStandardNormal) {
  Random random(4);
  constexpr int kDraws = 200000;
  std::array<double, 5> moments{};
  int beyond_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.Normal();
    ASSERT_TRUE(std::isfinite(x));
    beyond_two += std::abs(x) > 2;
    for (int k = 1; k <= 4; ++k) moments[k] += std::pow(x, k) / kDraws;
  }
  EXPECT_NEAR(moments[1], 0, 0.015);
  EXPECT_NEAR(moments[2], 1, 0.02);
  EXPECT_NEAR(moments[3], 0, 0.06);
  EXPECT_NEAR(moments[4], 3, 0.15);
  EXPECT_NEAR(static_cast<double>(beyond_two) / kDraws, 0.0455, 0.003);
}

}  // namespace
}  // namespace waystone
