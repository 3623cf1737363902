// SPDX-License-Identifier: Apache-2.0
#include "core/robust/lo_ransac.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace waystone {
namespace {

TEST(SamplesNeeded, IsEquationOne) {
  for (double p : {0.9, 0.99, 0.999}) {
    for (double w : {0.2, 0.5, 0.8, 0.95}) {
      const double w4 = std::pow(w, 4);
      EXPECT_NEAR(SamplesNeeded(p, w4), std::log(1 - p) / std::log(1 - w4), 1e-6);
      // What it means: the probability that all k samples miss is 1 - p.
      EXPECT_NEAR(std::pow(1 - w4, SamplesNeeded(p, w4)), 1 - p, 1e-9);
    }
  }
  EXPECT_NEAR(SamplesNeeded(0.99, std::pow(0.5, 4)), 71.36, 0.01);
}

TEST(SamplesNeeded, AtItsEnds) {
  EXPECT_EQ(SamplesNeeded(0.99, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(SamplesNeeded(0.99, 1), 1);
  EXPECT_GT(SamplesNeeded(0.99, 1e-17), 1e17)
      << "the smallest probabilities must not round to none";
}

// The line y = slope x + offset through two of many points.
struct MadePoint {
  double x = 0;
  double y = 0;
};
struct MadeLine {
  double slope = 0;
  double offset = 0;
};
struct LineFit {
  MadeLine line;
  double score = 0;
};

struct PairSampler {
  int points = 0;
  int refused = 0;  // every so many draws give nothing; 0 for none
  int draws = 0;

  std::optional<std::array<int, 2>> Draw(Random& random) {
    if (refused > 0 && ++draws % refused == 0) return std::nullopt;
    const int first = random.Below(points);
    const int second = random.Below(points);
    if (first == second) return std::nullopt;
    return std::array{first, second};
  }
};

struct LineEstimator {
  const std::vector<MadePoint>& points;
  mutable int refined = 0;

  std::vector<MadeLine> Estimate(const std::array<int, 2>& sample) const {
    const MadePoint& p = points[sample[0]];
    const MadePoint& q = points[sample[1]];
    if (p.x == q.x) return {};
    const double slope = (q.y - p.y) / (q.x - p.x);
    return {{slope, p.y - slope * p.x}};
  }

  double Score(const MadeLine& line) const {
    double score = 0;
    for (const MadePoint& p : points) {
      score += std::abs(line.slope * p.x + line.offset - p.y) < 0.01 ? 1 : 0;
    }
    return score;
  }

  LineFit Refine(const MadeLine& line) const {
    ++refined;
    return {line, Score(line)};
  }

  double SampleProbability(const LineFit& fit) const {
    const double share = fit.score / static_cast<double>(points.size());
    return share * share;
  }
};

std::vector<MadePoint> PointsOnALine(int inliers, int outliers) {
  std::vector<MadePoint> points;
  Random random(7);
  for (int i = 0; i < inliers; ++i) points.push_back({0.1 * i, 0.2 * i + 1});
  for (int i = 0; i < outliers; ++i) {
    points.push_back({random.Uniform(0, 10), random.Uniform(-20, 0)});
  }
  return points;
}

RansacResult<LineFit> RunLine(const std::vector<MadePoint>& points, const RansacLimits& limits,
                              uint64_t seed = 1, int refused = 0) {
  PairSampler sampler{static_cast<int>(points.size()), refused};
  Random random(seed);
  return RunLoRansac(sampler, LineEstimator{points}, limits, random);
}

TEST(LoRansac, FindsTheModelOfMostPoints) {
  const auto points = PointsOnALine(40, 60);
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const auto result = RunLine(points, {.confidence = 0.9999}, seed);
    EXPECT_NEAR(result.best.line.slope, 2, 1e-9);
    EXPECT_NEAR(result.best.line.offset, 1, 1e-9);
    EXPECT_GE(result.best.score, 40);
  }
}

TEST(LoRansac, DrawsAsManySamplesAsTheInliersAskFor) {
  const auto points = PointsOnALine(50, 0);
  const auto result = RunLine(points, {.max_samples = 500});
  EXPECT_LE(result.samples, 3) << "all are inliers";
  EXPECT_EQ(RunLine(points, {.max_samples = 500, .min_samples = 20}).samples, 20);
  EXPECT_EQ(RunLine(points, {.max_samples = 10, .min_samples = 20}).samples, 10);
  const auto none = PointsOnALine(0, 50);
  EXPECT_EQ(RunLine(none, {.max_samples = 37}).samples, 37);
}

TEST(LoRansac, DrawsWithoutASampleCountAsDraws) {
  const auto points = PointsOnALine(0, 50);
  EXPECT_EQ(RunLine(points, {.max_samples = 30}, 1, 1).samples, 30);
  EXPECT_EQ(RunLine(points, {.max_samples = 30}, 1, 1).best.score, 0) << "every draw gives nothing";
}

TEST(LoRansac, RefinesOnlyWhatMayBeatTheBest) {
  const auto points = PointsOnALine(40, 60);
  const auto refined = [&](double share) {
    PairSampler sampler{static_cast<int>(points.size())};
    const LineEstimator estimator{points};
    Random random(1);
    RunLoRansac(sampler, estimator, {.min_samples = 200, .min_refine_share = share}, random);
    return estimator.refined;
  };
  EXPECT_LT(refined(1), 10);
  EXPECT_GT(refined(0.01), 100);
}

TEST(LoRansac, IsTheSameForASeed) {
  const auto points = PointsOnALine(20, 80);
  EXPECT_EQ(RunLine(points, {}, 4).samples, RunLine(points, {}, 4).samples);
}

}  // namespace
}  // namespace waystone
