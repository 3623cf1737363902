// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/verdict_model.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

// Samples drawn from a model, so that the truth is known.
std::vector<VerdictSample> Draw(const VerdictModel& truth, int count, uint64_t seed) {
  Random random(seed);
  std::vector<VerdictSample> samples;
  for (int i = 0; i < count; ++i) {
    const Evidence evidence{4 + random.Below(30), random.Uniform(0.1, 0.9)};
    samples.push_back({evidence, random.Uniform() < EstimateProbability(evidence, truth)});
  }
  return samples;
}

TEST(VerdictModel, ProbabilityGrowsWithTheEvidence) {
  const VerdictModel model;
  double last = 0;
  for (int inliers = 0; inliers < 200; inliers += 5) {
    const double p = EstimateProbability({inliers, 0.5}, model);
    EXPECT_GT(p, last);
    EXPECT_LT(p, 1);
    last = p;
  }
  EXPECT_GT(EstimateProbability({10, 0.9}, model), EstimateProbability({10, 0.2}, model));
}

TEST(VerdictModel, WithFewSamplesTheGeneralModelHolds) {
  EXPECT_EQ(FitVerdictModel({}), VerdictModel{});
  std::vector<VerdictSample> samples(100, {{5, 0.2}, false});
  samples.insert(samples.end(), 9, {{60, 0.8}, true});
  VerdictModel general;
  general.positives = 9;
  general.negatives = 100;
  EXPECT_EQ(FitVerdictModel(samples), general);
  samples.push_back({{60, 0.8}, true});
  EXPECT_NE(FitVerdictModel(samples).intercept, general.intercept);
}

// In every tenth of the stated probability, what is stated must be what happens.
TEST(VerdictModel, StatesTheObservedFrequency) {
  const VerdictModel truth{-13, 5, 2, 0, 0};
  FitOptions loose;
  loose.intercept_sigma = loose.log_inliers_sigma = loose.inlier_share_sigma = 100;
  std::vector<VerdictSample> samples = Draw(truth, 20000, 1);
  // The fit weighs both classes the same; so must the samples.
  std::vector<VerdictSample> even;
  int right = 0;
  for (const VerdictSample& sample : samples) right += sample.right;
  int left = std::min<int>(right, static_cast<int>(samples.size()) - right);
  int counts[2] = {left, left};
  for (const VerdictSample& sample : samples) {
    if (counts[sample.right]-- > 0) even.push_back(sample);
  }
  const VerdictModel model = FitVerdictModel(even, loose);
  double stated[10] = {};
  int observed[10] = {};
  int seen[10] = {};
  for (const VerdictSample& sample : even) {
    const double p = EstimateProbability(sample.evidence, model);
    const int bin = std::min(9, static_cast<int>(10 * p));
    stated[bin] += p;
    observed[bin] += sample.right;
    ++seen[bin];
  }
  for (int bin = 0; bin < 10; ++bin) {
    if (seen[bin] < 100) continue;
    EXPECT_NEAR(stated[bin] / seen[bin], static_cast<double>(observed[bin]) / seen[bin], 0.1)
        << "bin " << bin;
  }
}

TEST(VerdictModel, SamplesThatAreToldApartDontDriveItToInfinity) {
  std::vector<VerdictSample> samples;
  for (int i = 0; i < 50; ++i) samples.push_back({{60 + i, 0.8}, true});
  for (int i = 0; i < 50; ++i) samples.push_back({{5, 0.2}, false});
  const VerdictModel model = FitVerdictModel(samples);
  EXPECT_LT(model.log_inliers, 15);
  EXPECT_GT(EstimateProbability({60, 0.8}, model), 0.95);
  EXPECT_LT(EstimateProbability({5, 0.2}, model), 0.05);
  EXPECT_EQ(model.positives, 50);
  EXPECT_EQ(model.negatives, 50);
}

TEST(VerdictModel, MoreInliersNeverSpeakAgainstAPlace) {
  std::vector<VerdictSample> samples;
  for (int i = 0; i < 200; ++i) samples.push_back({{6, 0.5}, true});
  for (int i = 0; i < 200; ++i) samples.push_back({{100, 0.5}, false});
  FitOptions loose;
  loose.log_inliers_sigma = 1000;
  EXPECT_GT(FitVerdictModel(samples, loose).log_inliers, 0);
}

TEST(VerdictModel, SigmasMustBePositive) {
  FitOptions options;
  options.log_inliers_sigma = 0;
  EXPECT_THROW(FitVerdictModel({}, options), MapError);
}

}  // namespace
}  // namespace waystone
