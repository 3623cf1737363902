// SPDX-License-Identifier: Apache-2.0
#include "core/robust/quantile.h"

#include <gtest/gtest.h>

namespace waystone {
namespace {

TEST(Quantile, IsTheNearestRank) {
  const std::vector<double> values = {4, 1, 3, 2};
  EXPECT_EQ(Quantile(values, 0), 1);
  EXPECT_EQ(Quantile(values, 0.25), 1);
  EXPECT_EQ(Quantile(values, 0.26), 2);
  EXPECT_EQ(Quantile(values, 0.5), 2);
  EXPECT_EQ(Quantile(values, 0.9), 4);
  EXPECT_EQ(Quantile(values, 1), 4);
  EXPECT_EQ(Quantile({}, 0.5), 0);
}

}  // namespace
}  // namespace waystone
