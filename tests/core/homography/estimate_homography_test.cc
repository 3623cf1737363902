// SPDX-License-Identifier: Apache-2.0
#include "core/homography/estimate_homography.h"

#include <gtest/gtest.h>

#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

// 60 matches of a plane and 40 of nothing.
MatchedPoints MadeMatches(const Eigen::Matrix3d& truth, Random& random) {
  const PointPairs pairs = PairsOf(truth, 60, 0.5, random);
  MatchedPoints matches{pairs.a, pairs.b, {}};
  for (int i = 0; i < 40; ++i) {
    matches.from.push_back(RandomPoint(random));
    matches.to.push_back(RandomPoint(random));
  }
  return matches;
}

TEST(EstimateHomography, IsTheRefinedOneOfItsInliers) {
  Random random(1);
  const Eigen::Matrix3d truth = RandomHomography(random);
  const MatchedPoints matches = MadeMatches(truth, random);
  const auto estimate = EstimateHomography(matches, {}, 3);
  ASSERT_TRUE(estimate);
  EXPECT_GE(estimate->inliers.size(), 55u);
  EXPECT_LT(LargestDifference(estimate->to_from.b_from_a, truth), 2);
  PointPairs pairs;
  for (const int row : estimate->inliers) pairs.Add(matches.from[row], matches.to[row]);
  const auto refined = RefineHomography(pairs, FindPlane(matches, {}, 3)->model.to_from);
  ASSERT_TRUE(refined);
  EXPECT_EQ(estimate->to_from.b_from_a, refined->b_from_a);
  EXPECT_EQ(estimate->to_from.pairs, static_cast<int>(estimate->inliers.size()));
  EXPECT_EQ(estimate->reference_from.pairs, 0);
}

TEST(EstimateHomography, OfTriplesGivesBothHomographies) {
  Random random(2);
  const Eigen::Matrix3d to_from = RandomHomography(random);
  const Eigen::Matrix3d reference_from = RandomHomography(random);
  MatchedPoints matches = MadeMatches(to_from, random);
  for (const Eigen::Vector2d& x : matches.from) {
    matches.reference.push_back(Apply(reference_from, x));
  }
  const auto estimate = EstimateHomography(matches, {}, 1);
  ASSERT_TRUE(estimate);
  EXPECT_LT(LargestDifference(estimate->to_from.b_from_a, to_from), 2);
  EXPECT_LT(LargestDifference(estimate->reference_from.b_from_a, reference_from), 2);
}

TEST(EstimateHomography, OfTooFewMatchesIsNothing) {
  EXPECT_FALSE(EstimateHomography({}, {}, 1));
  Random random(3);
  const PointPairs pairs = PairsOf(RandomHomography(random), 4, 0, random);
  EXPECT_FALSE(EstimateHomography({pairs.a, pairs.b, {}}, {}, 1)) << "four leave no noise to tell";
}

}  // namespace
}  // namespace waystone
