// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/appearance_verdict.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

AppearanceEvidence ByAppearance(double cost, double margin) {
  AppearanceEvidence evidence;
  evidence.cost = cost;
  evidence.margin = margin;
  return evidence;
}

TEST(AppearanceVerdict, MoreEvidenceIsMoreLikely) {
  const AppearanceVerdict model = DefaultVerdict(false);
  EXPECT_GT(EstimateProbability(ByAppearance(0.3, 0.3), model),
            EstimateProbability(ByAppearance(0.8, 0.3), model));
  EXPECT_GT(EstimateProbability(ByAppearance(0.5, 0.3), model),
            EstimateProbability(ByAppearance(0.5, 0), model));
}

TEST(AppearanceVerdict, FindsTheModelOfItsSamples) {
  AppearanceVerdict truth = DefaultVerdict(false);
  truth.intercept = 4;
  truth.terms[1].weight = -8;
  truth.terms[2].weight = 10;
  Random random(1);
  std::vector<AppearanceSample> samples;
  for (int i = 0; i < 4000; ++i) {
    const auto evidence = ByAppearance(random.Uniform(0, 1.2), random.Uniform(-0.3, 0.3));
    samples.push_back({evidence, random.Uniform() < EstimateProbability(evidence, truth)});
  }
  const AppearanceVerdict fitted = FitAppearanceVerdict(samples, false, {100, 100, 1});
  EXPECT_EQ(fitted.terms[1].name, "cost");
  EXPECT_NEAR(fitted.terms[1].weight, -8, 0.8);
  EXPECT_NEAR(fitted.terms[2].weight, 10, 1);
  EXPECT_EQ(fitted.positives + fitted.negatives, 4000);
}

TEST(AppearanceVerdict, WithFewSamplesTheDefaultHolds) {
  EXPECT_EQ(FitAppearanceVerdict({}, true), DefaultVerdict(true));
  std::vector<AppearanceSample> samples;
  for (int i = 0; i < 500; ++i) samples.push_back({ByAppearance(0.9, 0), false});
  for (int i = 0; i < 19; ++i) samples.push_back({ByAppearance(0.5, 0.1), true});
  AppearanceVerdict counted = DefaultVerdict(false);
  counted.positives = 19;
  counted.negatives = 500;
  EXPECT_EQ(FitAppearanceVerdict(samples, false), counted);
  samples.push_back({ByAppearance(0.5, 0.1), true});
  EXPECT_NE(FitAppearanceVerdict(samples, false).intercept, counted.intercept);
}

// Whatever the samples say: evidence can't count against what it means.
TEST(AppearanceVerdict, WeightsKeepTheSignsOfTheirEvidence) {
  std::vector<AppearanceSample> samples;
  for (int i = 0; i < 100; ++i) {
    samples.push_back({ByAppearance(0.9, -0.2 + 0.001 * i), true});
    samples.push_back({ByAppearance(0.3, 0.2 + 0.001 * i), false});
  }
  const AppearanceVerdict alone = FitAppearanceVerdict(samples, false);
  EXPECT_GE(alone.terms[0].weight, 0) << "agreement";
  EXPECT_LE(alone.terms[1].weight, 0) << "cost";
  EXPECT_GE(alone.terms[2].weight, 0) << "margin";
  samples.clear();
  for (int i = 0; i < 100; ++i) {
    AppearanceEvidence evidence;
    evidence.verified = true;
    const bool right = i % 2 == 0;
    evidence.log_inliers = right ? 2 : 5;
    evidence.log_inlier_margin = right ? 0.1 : 3;
    evidence.parallax_rad = right ? 0.5 : 0.01;
    evidence.sigma_spacings = right ? 1 : 0.1;
    samples.push_back({evidence, right});
  }
  const AppearanceVerdict verified = FitAppearanceVerdict(samples, true);
  EXPECT_LE(verified.terms[0].weight, 0) << "deviation";
  EXPECT_GE(verified.terms[1].weight, 0) << "inlier margin";
  EXPECT_GE(verified.terms[2].weight, 0) << "inliers";
  EXPECT_LE(verified.terms[3].weight, 0) << "parallax";
}

TEST(AppearanceVerdict, PlacesThatExcludeEachOtherShareTheProbability) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  EXPECT_NEAR(ProbabilityAgainst(0, kNone), 0.5, 1e-12);
  EXPECT_NEAR(ProbabilityAgainst(0, 0), 1.0 / 3, 1e-12);
  EXPECT_NEAR(ProbabilityAgainst(20, 20), 0.5, 1e-6);
  // Far surer than the other one: a product of independent probabilities would halve it.
  EXPECT_GT(ProbabilityAgainst(12, 6), 0.99);
  EXPECT_EQ(ProbabilityAgainst(0, 2000), 0);
  EXPECT_EQ(ProbabilityAgainst(2000, 0), 1);
}

TEST(AppearanceVerdict, AModelOfAnotherKindIsNotUsed) {
  AppearanceLayer layer;
  layer.verified_verdict = DefaultVerdict(true);
  layer.verified_verdict->intercept = 77;
  EXPECT_EQ(VerdictFor(layer, true).intercept, 77);
  EXPECT_EQ(VerdictFor(layer, false), DefaultVerdict(false));
  layer.verified_verdict->terms[0].name = "magic";
  EXPECT_EQ(VerdictFor(layer, true), DefaultVerdict(true));
  layer.verdict = DefaultVerdict(true);
  EXPECT_EQ(VerdictFor(layer, false), DefaultVerdict(false));
}

TEST(AppearanceVerdict, RefusesBadOptions) {
  EXPECT_THROW(FitAppearanceVerdict({}, true, {0, 1, 1}), MapError);
}

}  // namespace
}  // namespace waystone
