// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/misclassification.h"

#include <gtest/gtest.h>

namespace waystone::bench {
namespace {

TEST(Misclassification, TheSameLabelsUnderOtherNamesAreRight) {
  EXPECT_EQ(Misclassification({0, 1, 1, 2, 2}, {0, 2, 2, 1, 1}), 0);
}

TEST(Misclassification, NoPlaneStaysNoPlane) {
  EXPECT_EQ(Misclassification({0, 0, 0, 0}, {1, 1, 1, 1}), 1);
  EXPECT_EQ(Misclassification({1, 1, 1, 1}, {0, 0, 0, 0}), 1);
}

TEST(Misclassification, ASplitPlaneCountsItsLargerPartAlone) {
  EXPECT_DOUBLE_EQ(Misclassification({1, 1, 1, 1, 1}, {1, 1, 1, 2, 2}), 0.4);
}

TEST(Misclassification, TwoPlanesUnderOneLabelCountTheLargerAlone) {
  EXPECT_DOUBLE_EQ(Misclassification({1, 1, 1, 2, 2}, {1, 1, 1, 1, 1}), 0.4);
}

// Giving each found plane its own best true plane in turn would take 1 for the first and leave the
// second without.
TEST(Misclassification, TheAssignmentIsTheBestOfAll) {
  EXPECT_DOUBLE_EQ(Misclassification({1, 1, 1, 2, 2, 1, 1, 1}, {1, 1, 1, 1, 1, 2, 2, 2}), 0.375);
}

TEST(Misclassification, NothingIsRight) { EXPECT_EQ(Misclassification({}, {}), 0); }

}  // namespace
}  // namespace waystone::bench
