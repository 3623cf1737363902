// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/keyframe_verdict.h"

#include <gtest/gtest.h>

namespace waystone {
namespace {

TEST(KeyframeVerdict, EveryKindOfEvidenceSpeaksForAPlace) {
  const double p = ComputeProbability({6, 3, 0.3, 0.2, 0.6});
  EXPECT_GT(ComputeProbability({7, 3, 0.3, 0.2, 0.6}), p);
  EXPECT_GT(ComputeProbability({6, 4, 0.3, 0.2, 0.6}), p);
  EXPECT_GT(ComputeProbability({6, 3, 0.4, 0.2, 0.6}), p);
  EXPECT_GT(ComputeProbability({6, 3, 0.3, 0.3, 0.6}), p);
  EXPECT_GT(ComputeProbability({6, 3, 0.3, 0.2, 0.7}), p);
}

TEST(KeyframeVerdict, NothingFoundIsNoPlace) { EXPECT_LT(ComputeProbability({}), 0.01); }

TEST(KeyframeVerdict, MoreInliersThanRuleOutChanceAreNoFurtherEvidence) {
  EXPECT_EQ(ComputeProbability({50, 50, 0.15, 0.1, 0.6}),
            ComputeProbability({500, 500, 0.15, 0.1, 0.6}));
}

TEST(KeyframeVerdict, WhatRandomMatchesGiveIsNoPlaceHoweverWellItFits) {
  const auto probability = [](double significance, double independent_significance) {
    return ComputeProbability({.significance = significance,
                               .independent_significance = independent_significance,
                               .found_share = 1,
                               .coverage = 1,
                               .inlier_share = 1});
  };
  EXPECT_LE(probability(0, 20), 0.5);  // one or more geometries of random matches
  EXPECT_LT(probability(2, 20), 0.9);
  EXPECT_GT(probability(3, 20), 0.9);
  EXPECT_GT(probability(20, 0), 0.9);
}

TEST(KeyframeVerdict, APosterIsNotAPlace) {
  EXPECT_LT(ComputeProbability({50, 20, 0.13, 0.2, 0.6}), 0.9);  // much of it, little around it
  EXPECT_LT(ComputeProbability({20, 12, 0.3, 0.08, 0.6}), 0.9);  // in a corner of the image
  EXPECT_LT(ComputeProbability({11, 0, 0.4, 0.08, 0.93}), 0.9);  // two corners of a room
  EXPECT_GE(ComputeProbability({20, 10, 0.5, 0.25, 0.7}), 0.9);
  EXPECT_GE(ComputeProbability({20, 12, 0.1, 0.4, 0.7}), 0.9);   // all over the image
  EXPECT_LT(ComputeProbability({0, 0, 0.08, 0.25, 0.45}), 0.1);  // chance
}

}  // namespace
}  // namespace waystone
