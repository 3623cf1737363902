// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/homography/homography.h"
#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Vector8d = Eigen::Matrix<double, 8, 1>;

Vector8d Normals(Random& random) {
  Vector8d z;
  for (int k = 0; k < 8; ++k) z(k) = random.Normal();
  return z;
}

double Cost(const PointPairs& pairs, const Matrix3d& h) {
  const Matrix3d inverse = h.inverse();
  double cost = 0;
  for (int i = 0; i < pairs.size(); ++i) {
    cost += SymmetricTransferError2(h, inverse, pairs.a[i], pairs.b[i]);
  }
  return cost;
}

// A homography that is off by some pixels.
Matrix3d Disturbed(const Matrix3d& h, double px, Random& random) {
  Matrix3d other = h;
  other(0, 2) += px * random.Normal();
  other(1, 2) += px * random.Normal();
  for (int k : {0, 1}) other.block<1, 2>(k, 0) += px / 500 * Vector2d(random.Normal(), 0.5);
  other.block<1, 2>(2, 0) += px / 300000 * Vector2d(random.Normal(), random.Normal());
  return other;
}

TEST(RefineHomography, StaysAtTheTruthWithoutNoise) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    const auto refined = RefineHomography(PairsOf(truth, 30, 0, random), truth);
    ASSERT_TRUE(refined);
    EXPECT_LT(LargestDifference(refined->b_from_a, truth), 1e-6);
    EXPECT_LT(refined->sigma_px, 1e-6);
    EXPECT_EQ(refined->pairs, 30);
    EXPECT_DOUBLE_EQ(refined->b_from_a(2, 2), 1);
  }
}

TEST(RefineHomography, FindsTheTruthFromADisturbedStart) {
  Random random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    const PointPairs pairs = PairsOf(truth, 30, 0, random);
    const auto refined = RefineHomography(pairs, Disturbed(truth, 5, random));
    ASSERT_TRUE(refined);
    EXPECT_LT(LargestDifference(refined->b_from_a, truth), 1e-2) << "trial " << trial;
  }
}

TEST(RefineHomography, NeverEndsWorseThanItStarts) {
  Random random(3);
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    const PointPairs pairs = PairsOf(truth, 8 + random.Below(50), 1.0, random);
    const Matrix3d initial = Disturbed(truth, random.Uniform(0, 5), random);
    const auto refined = RefineHomography(pairs, initial);
    ASSERT_TRUE(refined);
    // The two images are weighed by Hartley's normalisation, so that pixels are all but the same.
    EXPECT_LE(Cost(pairs, refined->b_from_a), Cost(pairs, initial) * 1.05) << "trial " << trial;
  }
}

// At a minimum, no small step along any entry lowers the cost.
TEST(RefineHomography, EndsNearAMinimumOfTheSymmetricTransferError) {
  Random random(4);
  for (int trial = 0; trial < 30; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    const PointPairs pairs = PairsOf(truth, 60, 1.0, random);
    const auto refined = RefineHomography(pairs, Disturbed(truth, 2, random));
    ASSERT_TRUE(refined);
    const double cost = Cost(pairs, refined->b_from_a);
    for (int draw = 0; draw < 20; ++draw) {
      const Matrix3d other = Perturbed(*refined, 0.5 * Normals(random));
      EXPECT_GT(Cost(pairs, other), cost * 0.995) << "trial " << trial;
    }
  }
}

TEST(RefineHomography, BeatsTheLinearEstimateOnAverage) {
  Random random(5);
  double linear = 0;
  double refined = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    const PointPairs pairs = PairsOf(truth, 20, 1.0, random);
    const auto dlt = HomographyByDlt(pairs);
    ASSERT_TRUE(dlt);
    const auto estimate = RefineHomography(pairs, *dlt);
    ASSERT_TRUE(estimate);
    linear += Cost(pairs, *dlt);
    refined += Cost(pairs, estimate->b_from_a);
  }
  EXPECT_LT(refined, linear);
}

TEST(RefineHomography, SigmaIsTheNoiseOfATransferError) {
  Random random(6);
  const Matrix3d truth = Matrix3d::Identity();
  for (double sigma : {0.2, 1.0, 3.0}) {
    const auto refined = RefineHomography(PairsOf(truth, 400, sigma, random), truth);
    ASSERT_TRUE(refined);
    // Both points of a pair are noisy, so an error's coordinate has sqrt(2) sigma.
    EXPECT_NEAR(refined->sigma_px / (std::sqrt(2.0) * sigma), 1, 0.1);
  }
}

// Standard sigma of where a homography sends points, from its own spread and from the same
// scene measured many times.
struct Sigmas {
  std::vector<double> stated;
  std::vector<double> true_ones;
};

Sigmas CompareSigmas(const Matrix3d& truth, int count, double sigma, const Box& box,
                     Random& random) {
  const std::vector<Vector2d> probes = {{box.x, box.y},
                                        {box.x + box.width, box.y},
                                        {box.x + box.width / 2, box.y + box.height / 2},
                                        {box.x - box.width / 2, box.y + box.height * 1.5}};
  constexpr int kRuns = 400;
  Sigmas sigmas{std::vector<double>(probes.size()), std::vector<double>(probes.size())};
  const PointPairs exact = PairsOf(truth, count, 0, random, box);
  for (int run = 0; run < kRuns; ++run) {
    PointPairs noisy;
    for (int i = 0; i < count; ++i) {
      noisy.Add(exact.a[i] + sigma * Vector2d(random.Normal(), random.Normal()),
                exact.b[i] + sigma * Vector2d(random.Normal(), random.Normal()));
    }
    const auto estimate = RefineHomography(noisy, truth);
    EXPECT_TRUE(estimate);
    if (!estimate) continue;
    const Matrix3d drawn = Perturbed(*estimate, Normals(random));
    for (size_t p = 0; p < probes.size(); ++p) {
      const Vector2d here = Apply(estimate->b_from_a, probes[p]);
      sigmas.stated[p] += (Apply(drawn, probes[p]) - here).squaredNorm() / kRuns;
      sigmas.true_ones[p] += (Apply(truth, probes[p]) - here).squaredNorm() / kRuns;
    }
  }
  return sigmas;
}

TEST(RefineHomography, SpreadAgreesWithMonteCarlo) {
  Random random(7);
  for (int scene = 0; scene < 6; ++scene) {
    const Matrix3d truth = RandomHomography(random);
    const int count = scene % 2 == 0 ? 25 : 80;
    const Box box = scene < 3 ? Box{} : Box{220, 130, 180, 140};
    const Sigmas sigmas = CompareSigmas(truth, count, 0.7, box, random);
    for (size_t p = 0; p < sigmas.stated.size(); ++p) {
      const double ratio = std::sqrt(sigmas.stated[p] / sigmas.true_ones[p]);
      EXPECT_GT(ratio, 1 / 1.5) << "scene " << scene << ", probe " << p;
      EXPECT_LT(ratio, 1.5) << "scene " << scene << ", probe " << p;
    }
  }
}

TEST(RefineHomography, MorePairsAndLessNoiseMakeItSurer) {
  Random random(8);
  const Matrix3d truth = RandomHomography(random);
  const auto spread = [&](int count, double sigma) {
    const auto estimate = RefineHomography(PairsOf(truth, count, sigma, random), truth);
    EXPECT_TRUE(estimate);
    return estimate->spread.row(2).norm();  // of h13, in px
  };
  EXPECT_NEAR(spread(1600, 1) / spread(100, 1), 0.25, 0.1);
  EXPECT_NEAR(spread(400, 0.3) / spread(400, 1.2), 0.25, 0.1);
}

TEST(RefineHomography, NeedsFivePairs) {
  Random random(9);
  const Matrix3d truth = RandomHomography(random);
  for (int count = 0; count < 5; ++count) {
    EXPECT_FALSE(RefineHomography(PairsOf(truth, count, 0.1, random), truth)) << count;
  }
  EXPECT_TRUE(RefineHomography(PairsOf(truth, 6, 0.1, random), truth));
}

TEST(RefineHomography, GivesNothingUsableForPointsInALine) {
  PointPairs line;
  for (int i = 0; i < 20; ++i) line.Add(Vector2d(10 * i, 20 * i), Vector2d(10 * i + 3, 20 * i));
  const auto refined = RefineHomography(line, Matrix3d::Identity());
  if (refined) {
    EXPECT_TRUE(refined->b_from_a.allFinite());
    EXPECT_TRUE(refined->spread.allFinite());
  }
}

TEST(Perturbed, IsTheEstimateForZero) {
  Random random(10);
  const Matrix3d truth = RandomHomography(random);
  const auto estimate = RefineHomography(PairsOf(truth, 40, 1, random), truth);
  ASSERT_TRUE(estimate);
  EXPECT_EQ(Perturbed(*estimate, Vector8d::Zero()), estimate->b_from_a);
  EXPECT_NEAR(Perturbed(*estimate, Normals(random))(2, 2), 1, 1e-9);
}

TEST(Composed, IsTheProductWithItsNoise) {
  Random random(11);
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix3d truth = RandomHomography(random);
    const Matrix3d c_from_b = RandomHomography(random);
    const auto estimate = RefineHomography(PairsOf(truth, 60, 0.3, random), truth);
    ASSERT_TRUE(estimate);
    const HomographyEstimate composed = Composed(c_from_b, *estimate);
    EXPECT_TRUE(composed.b_from_a.isApprox(Normalised(c_from_b * estimate->b_from_a), 1e-12));
    EXPECT_EQ(composed.pairs, estimate->pairs);
    // Small draws: to first order, perturbing and composing commute.
    const Vector8d z = 1e-3 * Normals(random);
    const Matrix3d before = c_from_b * Perturbed(*estimate, z);
    const Matrix3d after = Perturbed(composed, z);
    const double moved = LargestDifference(after, composed.b_from_a);
    EXPECT_LT(LargestDifference(before, after), 1e-2 * moved + 1e-9) << "trial " << trial;
  }
}

TEST(Composed, WithTheIdentityChangesNothing) {
  Random random(12);
  const Matrix3d truth = RandomHomography(random);
  const auto estimate = RefineHomography(PairsOf(truth, 40, 1, random), truth);
  ASSERT_TRUE(estimate);
  const HomographyEstimate composed = Composed(Matrix3d::Identity(), *estimate);
  EXPECT_TRUE(composed.b_from_a.isApprox(estimate->b_from_a, 1e-14));
  EXPECT_TRUE(composed.spread.isApprox(estimate->spread, 1e-9));
}

// To first order it is the sigma of the drawn homographies' images.
TEST(TransferSigma, IsTheSigmaOfDrawnHomographies) {
  Random random(21);
  const Matrix3d truth = RandomHomography(random);
  const Box box{100, 100, 300, 200};
  const auto estimate = RefineHomography(PairsOf(truth, 60, 0.3, random, box), truth);
  ASSERT_TRUE(estimate);
  for (const Vector2d& x : {Vector2d(250, 200), Vector2d(110, 290), Vector2d(500, 350)}) {
    constexpr int kDraws = 4000;
    double square = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const Matrix3d drawn = Perturbed(*estimate, Normals(random));
      square += (Apply(drawn, x) - Apply(estimate->b_from_a, x)).squaredNorm() / kDraws;
    }
    EXPECT_NEAR(TransferSigma(*estimate, x), std::sqrt(square), 0.05 * std::sqrt(square));
  }
  EXPECT_GT(TransferSigma(*estimate, {500, 350}), 2 * TransferSigma(*estimate, {250, 200}));
}

}  // namespace
}  // namespace waystone
