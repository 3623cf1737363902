// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/appearance_verdict.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "core/base/check.h"
#include "localizer/verdict/logistic_fit.h"

namespace waystone {
namespace {

// A kind of evidence: the name under which maps store its weight, its field, and whether it counts
// for a place (1) or against it (-1).
struct Term {
  const char* name;
  double AppearanceEvidence::*of;
  int sign;
};

// By kind, names ascending, as stored in maps.
constexpr Term kAlone[] = {{"agreement", &AppearanceEvidence::agreement, 1},
                           {"cost", &AppearanceEvidence::cost, -1},
                           {"margin", &AppearanceEvidence::margin, 1}};
constexpr Term kVerified[] = {{"deviation_spacings", &AppearanceEvidence::sigma_spacings, -1},
                              {"log_inlier_margin", &AppearanceEvidence::log_inlier_margin, 1},
                              {"log_inliers", &AppearanceEvidence::log_inliers, 1},
                              {"parallax_rad", &AppearanceEvidence::parallax_rad, -1}};

std::span<const Term> TermsOf(bool verified) {
  return verified ? std::span<const Term>(kVerified) : std::span<const Term>(kAlone);
}

// 1, then the evidence in the order of the terms.
Eigen::VectorXd FactorsOf(const AppearanceEvidence& evidence, bool verified) {
  const std::span<const Term> terms = TermsOf(verified);
  Eigen::VectorXd factors(1 + terms.size());
  factors(0) = 1;
  for (size_t i = 0; i < terms.size(); ++i) factors(1 + i) = evidence.*(terms[i].of);
  return factors;
}

Eigen::VectorXd CoefficientsOf(const AppearanceVerdict& model) {
  Eigen::VectorXd coefficients(1 + model.terms.size());
  coefficients(0) = model.intercept;
  for (size_t i = 0; i < model.terms.size(); ++i) coefficients(1 + i) = model.terms[i].weight;
  return coefficients;
}

bool IsOfKind(const AppearanceVerdict& model, bool verified) {
  return std::ranges::equal(model.terms, TermsOf(verified), {}, &VerdictTerm::name, &Term::name);
}

AppearanceVerdict ModelOf(const Eigen::VectorXd& coefficients, bool verified) {
  AppearanceVerdict model;
  model.intercept = coefficients(0);
  const std::span<const Term> terms = TermsOf(verified);
  for (size_t i = 0; i < terms.size(); ++i) {
    model.terms.push_back({terms[i].name, coefficients(1 + i)});
  }
  return model;
}

LogisticPrior PriorOf(bool verified, const AppearanceFitOptions& options) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  LogisticPrior prior;
  prior.mean = CoefficientsOf(DefaultVerdict(verified));
  prior.sigma = Eigen::VectorXd::Constant(prior.mean.size(), options.weight_sigma);
  prior.sigma(0) = options.intercept_sigma;
  prior.lower = Eigen::VectorXd::Constant(prior.mean.size(), -kAny);
  prior.upper = Eigen::VectorXd::Constant(prior.mean.size(), kAny);
  const std::span<const Term> terms = TermsOf(verified);
  for (size_t i = 0; i < terms.size(); ++i) {
    (terms[i].sign > 0 ? prior.lower : prior.upper)(1 + i) = 0;
  }
  return prior;
}

}  // namespace

void AppearanceFitOptions::Check() const { CheckFields("appearance_verdict", *this); }

AppearanceVerdict DefaultVerdict(bool verified) {
  // Believed are more than 13 inliers, far more than for any other place, seen from nearby; or a
  // view of half the typical cost that stands out.
  Eigen::VectorXd coefficients(5);
  coefficients << -12, -1, 1.5, 4, -4;
  return verified ? ModelOf(coefficients, true) : ModelOf(Eigen::Vector4d(4, 1, -10, 15), false);
}

AppearanceVerdict VerdictFor(const AppearanceLayer& layer, bool verified) {
  const auto& kept = verified ? layer.verified_verdict : layer.verdict;
  return kept && IsOfKind(*kept, verified) ? *kept : DefaultVerdict(verified);
}

double EstimateLogOdds(const AppearanceEvidence& evidence, const AppearanceVerdict& model) {
  WS_CHECK(IsOfKind(model, evidence.verified), "a model for evidence of another kind");
  return CoefficientsOf(model).dot(FactorsOf(evidence, evidence.verified));
}

double EstimateProbability(const AppearanceEvidence& evidence, const AppearanceVerdict& model) {
  return Logistic(EstimateLogOdds(evidence, model));
}

double ProbabilityAgainst(double log_odds, double rival_log_odds) {
  // e^a / (1 + e^a + e^b) without overflow.
  return 1 / (1 + std::exp(-log_odds) + std::exp(rival_log_odds - log_odds));
}

AppearanceVerdict FitAppearanceVerdict(std::span<const AppearanceSample> samples, bool verified,
                                       const AppearanceFitOptions& options) {
  options.Check();
  const auto positives = std::ranges::count_if(samples, &AppearanceSample::right);
  const auto negatives = std::ssize(samples) - positives;
  const auto counted = [&](AppearanceVerdict model) {
    model.positives = static_cast<int>(positives);
    model.negatives = static_cast<int>(negatives);
    return model;
  };
  if (std::min(positives, negatives) < options.min_samples) {
    return counted(DefaultVerdict(verified));
  }
  std::vector<LogisticSample> cases;
  for (const AppearanceSample& sample : samples) {
    const auto alike = static_cast<double>(sample.right ? positives : negatives);
    const double balance = static_cast<double>(samples.size()) / (2 * alike);
    cases.push_back({FactorsOf(sample.evidence, verified), sample.right,
                     sample.right ? balance : balance * options.wrong_weight});
  }
  return counted(ModelOf(FitLogistic(cases, PriorOf(verified, options)), verified));
}

}  // namespace waystone
