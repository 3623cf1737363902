// SPDX-License-Identifier: Apache-2.0
#include "core/trajectory/shape_difference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

Points2 RandomPoints(uint64_t seed, int count) {
  Random random(seed);
  Points2 points;
  for (int i = 0; i < count; ++i) points.emplace_back(random.Uniform(-5, 5), random.Uniform(-2, 2));
  return points;
}

Similarity2 RandomSimilarity(uint64_t seed, bool reflect) {
  Random random(seed);
  const double angle = random.Uniform(-3, 3);
  Similarity2 s;
  s.scale = random.Uniform(0.01, 30);
  s.rotation << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  if (reflect) s.rotation.col(0) *= -1;
  s.translation = {random.Uniform(-100, 100), random.Uniform(-100, 100)};
  return s;
}

Points2 Moved(const Points2& points, const Similarity2& by) {
  Points2 moved;
  for (const auto& point : points) moved.push_back(by * point);
  return moved;
}

TEST(ShapeDifference, ASimilarShapeHasNone) {
  for (uint64_t seed = 0; seed < 40; ++seed) {
    const Points2 estimate = RandomPoints(seed, 3 + static_cast<int>(seed));
    const Similarity2 truth_from_estimate = RandomSimilarity(seed, seed % 2 == 0);
    const ShapeDifference found = CompareShapes(Moved(estimate, truth_from_estimate), estimate);
    EXPECT_LT(found.mu, 1e-12);
    EXPECT_NEAR(found.truth_from_estimate.scale / truth_from_estimate.scale, 1, 1e-9);
    EXPECT_TRUE(found.truth_from_estimate.rotation.isApprox(truth_from_estimate.rotation, 1e-6));
  }
}

// By its definition it doesn't matter which of the two is the truth, nor how either lies.
TEST(ShapeDifference, IsSymmetricAndBlindToSimilarities) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Points2 a = RandomPoints(seed, 20);
    const Points2 b = RandomPoints(seed + 1000, 20);
    const double mu = CompareShapes(a, b).mu;
    EXPECT_GT(mu, 0.1);
    EXPECT_LE(mu, 1);
    EXPECT_NEAR(CompareShapes(b, a).mu, mu, 1e-12);
    EXPECT_NEAR(CompareShapes(Moved(a, RandomSimilarity(seed, true)), b).mu, mu, 1e-9);
  }
}

// Nothing that lies close to the alignment found fits better.
TEST(ShapeDifference, TheAlignmentIsTheBest) {
  const Points2 truth = RandomPoints(1, 15);
  Points2 estimate = truth;
  Random random(3);
  for (auto& point : estimate) point += 0.5 * Eigen::Vector2d(random.Normal(), random.Normal());
  const auto cost = [&](const Similarity2& s) {
    double sum = 0;
    for (size_t i = 0; i < truth.size(); ++i) sum += (truth[i] - s * estimate[i]).squaredNorm();
    return sum;
  };
  const Similarity2 best = Align(truth, estimate);
  for (int i = 0; i < 200; ++i) {
    Similarity2 other = best;
    const double angle = 0.01 * random.Normal();
    Eigen::Matrix2d turn;
    turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    other.rotation = turn * best.rotation;
    other.scale *= 1 + 0.01 * random.Normal();
    other.translation += 0.01 * Eigen::Vector2d(random.Normal(), random.Normal());
    EXPECT_GE(cost(other), cost(best));
  }
}

// (0,0), (1,0), (0,1) against (0,0), (1,0), (0,0): by hand, 1 - (s1 + s2)^2 / (4/3 * 2/3) with the
// singular values sqrt(5)/3 and 0 of the covariance: 1 - (5/9) / (8/9).
TEST(ShapeDifference, AnExampleByHand) {
  EXPECT_NEAR(CompareShapes({{0, 0}, {1, 0}, {0, 1}}, {{0, 0}, {1, 0}, {0, 0}}).mu, 3.0 / 8, 1e-12);
}

TEST(ShapeDifference, WithoutReflectionAMirroredShapeDiffers) {
  const Points2 truth = {{0, 0}, {4, 0}, {4, 1}, {2, 3}};
  Points2 mirrored = truth;
  for (auto& point : mirrored) point.x() *= -1;
  EXPECT_LT(CompareShapes(truth, mirrored).mu, 1e-12);
  const Similarity2 turned = Align(truth, mirrored, {.scale = true, .reflect = false});
  EXPECT_NEAR(turned.rotation.determinant(), 1, 1e-12);
  EXPECT_GT((truth[3] - turned * mirrored[3]).norm(), 0.1);
}

TEST(ShapeDifference, WhatHasNoShapeIsRefused) {
  const auto refused = [](const Points2& truth, const Points2& estimate, const std::string& cause) {
    try {
      CompareShapes(truth, estimate);
      ADD_FAILURE() << cause;
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadSource);
      EXPECT_NE(std::string(error.what()).find(cause), std::string::npos) << error.what();
    }
  };
  const Points2 good = {{0, 0}, {1, 0}, {0, 1}};
  refused({{0, 0}, {1, 1}}, {{0, 0}, {1, 1}}, "at least 3");
  refused(good, {{0, 0}, {1, 1}}, "2 points");
  refused(good, {{7, 7}, {7, 7}, {7, 7}}, "estimate coincide");
  refused({{0, 0}, {0, 0}, {0, 0}}, good, "truth coincide");
  refused(good, {{0, 0}, {1, 1}, {0, std::numeric_limits<double>::infinity()}}, "is not finite");
}

}  // namespace
}  // namespace waystone
