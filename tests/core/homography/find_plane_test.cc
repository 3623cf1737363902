// SPDX-License-Identifier: Apache-2.0
#include "core/homography/find_plane.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

#include "core/base/error.h"
#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

std::vector<int> RowsUpTo(int count) {
  std::vector<int> rows(count);
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

void Append(MatchedPoints& points, const PointPairs& pairs) {
  points.from.insert(points.from.end(), pairs.a.begin(), pairs.a.end());
  points.to.insert(points.to.end(), pairs.b.begin(), pairs.b.end());
}

void AppendOutliers(MatchedPoints& points, int count, Random& random) {
  for (int i = 0; i < count; ++i) {
    points.from.push_back(RandomPoint(random));
    points.to.push_back(RandomPoint(random));
  }
}

std::optional<PlaneFit> Find(const MatchedPoints& points, std::span<const int> active,
                             uint64_t seed, const LocalRansacOptions& options = {}) {
  const Neighbourhoods neighbourhoods(points.from, 3 * options.neighbourhood);
  Random random(seed);
  return FindPlane(points, active, neighbourhoods, options, random);
}

int CountBelow(const std::vector<int>& rows, int limit) {
  return static_cast<int>(
      std::count_if(rows.begin(), rows.end(), [&](int r) { return r < limit; }));
}

TEST(PlaneError2, IsTheLargerOfBothErrorsInPixelsOfFrom) {
  MatchedPoints points;
  points.from = {Vector2d(10, 10)};
  points.to = {Vector2d(13, 10)};  // 3 px off the identity in either image
  const PlaneModel identity;
  EXPECT_DOUBLE_EQ(PlaneError2(points, identity, Inverse(identity), 0), 9);
  PlaneModel model;
  model.reference_from.diagonal() << 10, 10, 1;  // the reference image is ten times enlarged
  points.reference = {Vector2d(150, 100)};       // 50 px there are 5 px in `from`
  EXPECT_DOUBLE_EQ(PlaneError2(points, model, Inverse(model), 0), 25);
  points.reference = {Vector2d(110, 100)};
  EXPECT_DOUBLE_EQ(PlaneError2(points, model, Inverse(model), 0), 9);
}

TEST(FindPlane, FindsAPlaneAmongOutliers) {
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    const Matrix3d truth = RandomHomography(random);
    MatchedPoints points;
    Append(points, PairsOf(truth, 60, 0.5, random));
    AppendOutliers(points, 60, random);
    const auto fit = Find(points, RowsUpTo(points.size()), seed);
    ASSERT_TRUE(fit) << "seed " << seed;
    EXPECT_GE(CountBelow(fit->inliers, 60), 57) << "seed " << seed;
    EXPECT_LE(fit->inliers.size(), 64u) << "seed " << seed;
    EXPECT_LT(LargestDifference(fit->model.to_from, truth), 4) << "seed " << seed;
    EXPECT_TRUE(std::is_sorted(fit->inliers.begin(), fit->inliers.end()));
    EXPECT_GE(fit->samples, 1);
    EXPECT_LE(fit->samples, LocalRansacOptions{}.max_samples);
  }
}

TEST(FindPlane, ItsInliersAreTheRowsThatFitItsModelBest) {
  Random random(2);
  MatchedPoints points;
  Append(points, PairsOf(RandomHomography(random), 80, 1.0, random));
  AppendOutliers(points, 40, random);
  const LocalRansacOptions options;
  const auto fit = Find(points, RowsUpTo(points.size()), 5, options);
  ASSERT_TRUE(fit);
  const PlaneModel inverse = Inverse(fit->model);
  double largest_in = 0;
  double smallest_out = std::numeric_limits<double>::infinity();
  for (int i = 0; i < points.size(); ++i) {
    const double error = std::sqrt(PlaneError2(points, fit->model, inverse, i));
    if (std::binary_search(fit->inliers.begin(), fit->inliers.end(), i)) {
      largest_in = std::max(largest_in, error);
    } else {
      smallest_out = std::min(smallest_out, error);
    }
  }
  EXPECT_LT(largest_in, options.max_error_px);
  EXPECT_LE(largest_in, smallest_out);
  EXPECT_GT(fit->score, 0);
  EXPECT_LT(fit->score, static_cast<double>(fit->inliers.size()));
}

TEST(FindPlane, TakesTheLargestOfSeveralPlanes) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const MadeViews views = RandomViews(random);
    const Matrix3d truth = views.HomographyOf({{0, 0, 1}, 4});
    MatchedPoints points;
    Append(points, PairsOf(truth, 90, 0.5, random, {0, 0, 300, 480}));
    Append(points,
           PairsOf(views.HomographyOf({{0.8, 0, 0.6}, 1.2}), 40, 0.5, random, {310, 0, 330, 230}));
    Append(points, PairsOf(views.HomographyOf({{0, 0.8, 0.6}, 1.0}), 40, 0.5, random,
                           {310, 250, 330, 230}));
    AppendOutliers(points, 30, random);
    const auto fit = Find(points, RowsUpTo(points.size()), seed);
    ASSERT_TRUE(fit) << "seed " << seed;
    EXPECT_GE(CountBelow(fit->inliers, 90), 84) << "seed " << seed;
  }
}

TEST(FindPlane, OnlyActiveRowsCount) {
  Random random(3);
  const Matrix3d first = RandomHomography(random);
  const Matrix3d second = RandomHomography(random);
  MatchedPoints points;
  Append(points, PairsOf(first, 100, 0.3, random));
  Append(points, PairsOf(second, 40, 0.3, random));
  std::vector<int> active(40);
  std::iota(active.begin(), active.end(), 100);
  const auto fit = Find(points, active, 1);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->inliers, active);
}

// Sec. II-A: each feature must support both homographies.
TEST(FindPlane, ATripleMatchMustSupportBothHomographies) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Matrix3d to_from = RandomHomography(random);
    const Matrix3d reference_from = RandomHomography(random);
    const PointPairs pairs = PairsOf(to_from, 90, 0.3, random);
    MatchedPoints points;
    Append(points, pairs);
    for (int i = 0; i < 90; ++i) {
      const Vector2d exact = Apply(reference_from, pairs.a[i]);
      points.reference.push_back(i < 60 ? exact : RandomPoint(random));
      if (i < 15) points.to[i] = RandomPoint(random);
    }
    const auto fit = Find(points, RowsUpTo(90), seed);
    ASSERT_TRUE(fit) << "seed " << seed;
    // Rows 0 to 14 fail `to`, rows 60 to 89 fail the reference: 15 to 59 support both.
    EXPECT_GE(fit->inliers.size(), 44u) << "seed " << seed;
    EXPECT_LE(CountBelow(fit->inliers, 15), 1) << "seed " << seed;
    EXPECT_GE(CountBelow(fit->inliers, 60), static_cast<int>(fit->inliers.size()) - 1);
    EXPECT_LT(LargestDifference(fit->model.to_from, to_from), 3) << "seed " << seed;
    EXPECT_LT(LargestDifference(fit->model.reference_from, reference_from), 3) << "seed " << seed;
  }
}

TEST(FindPlane, IsDeterministicForASeed) {
  Random random(4);
  MatchedPoints points;
  Append(points, PairsOf(RandomHomography(random), 50, 1.0, random));
  AppendOutliers(points, 80, random);
  const auto once = Find(points, RowsUpTo(points.size()), 9);
  const auto again = Find(points, RowsUpTo(points.size()), 9);
  ASSERT_TRUE(once && again);
  EXPECT_EQ(once->inliers, again->inliers);
  EXPECT_EQ(once->model.to_from, again->model.to_from);
  EXPECT_EQ(once->samples, again->samples);
}

TEST(FindPlane, OfAllRowsHasNeighbourhoodsOfItsOwn) {
  Random random(9);
  MatchedPoints points;
  Append(points, PairsOf(RandomHomography(random), 50, 0.5, random));
  AppendOutliers(points, 30, random);
  const LocalRansacOptions options;
  const Neighbourhoods neighbourhoods(points.from, 2 * options.neighbourhood);
  Random draws(5);
  const auto expected = FindPlane(points, RowsUpTo(points.size()), neighbourhoods, options, draws);
  const auto fit = FindPlane(points, options, 5);
  ASSERT_TRUE(expected && fit);
  EXPECT_EQ(fit->inliers, expected->inliers);
  EXPECT_EQ(fit->model.to_from, expected->model.to_from);
}

TEST(FindPlane, FewSamplesAreEnoughWithoutOutliers) {
  Random random(5);
  MatchedPoints points;
  Append(points, PairsOf(RandomHomography(random), 80, 0.1, random));
  const auto fit = Find(points, RowsUpTo(80), 1);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->inliers.size(), 80u);
  EXPECT_LT(fit->samples, 20);
}

TEST(FindPlane, MaxSamplesBoundsTheSearch) {
  Random random(6);
  MatchedPoints points;
  AppendOutliers(points, 100, random);
  LocalRansacOptions options;
  options.max_samples = 37;
  const auto fit = Find(points, RowsUpTo(100), 1, options);
  EXPECT_LE(fit ? fit->samples : 0, 37);
}

TEST(FindPlane, NoiseAloneHasOnlyTinyPlanes) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    MatchedPoints points;
    AppendOutliers(points, 150, random);
    const auto fit = Find(points, RowsUpTo(150), seed);
    EXPECT_LE(fit ? fit->inliers.size() : 0, 12u) << "seed " << seed;
  }
}

TEST(FindPlane, NothingWithoutFourRowsOrInALine) {
  Random random(7);
  MatchedPoints points;
  Append(points, PairsOf(RandomHomography(random), 30, 0, random));
  for (int count = 0; count < 4; ++count) EXPECT_FALSE(Find(points, RowsUpTo(count), 1)) << count;
  EXPECT_FALSE(Find({}, {}, 1));
  MatchedPoints line;
  for (int i = 0; i < 40; ++i) {
    line.from.emplace_back(10 * i, 5 * i);
    line.to.emplace_back(9 * i, 6 * i);
  }
  EXPECT_FALSE(Find(line, RowsUpTo(40), 1));
}

TEST(LocalOptimize, NeverLosesScoreAndKeepsTheSamples) {
  Random random(8);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    MatchedPoints points;
    Append(points, PairsOf(truth, 80, 0.3, random));
    AppendOutliers(points, 40, random);
    PlaneFit start;  // the truth, seen from a corner of the image only
    start.model.to_from = truth;
    start.samples = 11;
    for (int i = 0; i < 80; ++i) {
      if (points.from[i].x() < 300) start.inliers.push_back(i);
    }
    const PlaneFit grown = LocalOptimize(points, RowsUpTo(points.size()), start, {});
    EXPECT_EQ(grown.samples, 11);
    EXPECT_GE(grown.score, start.score);
    EXPECT_GE(grown.inliers.size(), 70u);
  }
}

TEST(LocalRansacOptions, OutOfTheirRangeAreRefused) {
  const auto expect_refused = [](const LocalRansacOptions& options) {
    try {
      options.Check();
      ADD_FAILURE() << "an option out of its range was taken";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    }
  };
  expect_refused({.max_error_px = 0});
  expect_refused({.max_error_px = std::numeric_limits<double>::quiet_NaN()});
  expect_refused({.confidence = 0});
  expect_refused({.confidence = 1});
  expect_refused({.max_samples = 0});
  expect_refused({.neighbourhood = 2});
  expect_refused({.min_height_ratio = -0.1});
  expect_refused({.min_height_ratio = 0.5});
  expect_refused({.max_refits = -1});
  EXPECT_NO_THROW(LocalRansacOptions{}.Check());
}

}  // namespace
}  // namespace waystone
