// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/appearance_verdict.h"

#include <gtest/gtest.h>

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

TEST(AppearanceVerdict, WithoutSamplesTheDefaultHolds) {
  EXPECT_EQ(FitAppearanceVerdict({}, true), DefaultVerdict(true));
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
