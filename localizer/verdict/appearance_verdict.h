// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/base/options.h"
#include "schema/layers/appearance/appearance_layer.h"

namespace waystone {

// The evidence for a node as the place of a panorama. Terms of AppearanceVerdict, by name:
//   "agreement", "cost", "margin"  for answers by appearance only;
//   "deviation_spacings", "log_inlier_margin", "log_inliers", "parallax_rad"  for answers that were
//                                  verified by features.
struct AppearanceEvidence {
  double cost = 0;       // 0 the same view, about 1 another place
  double margin = 0;     // by how much the best place elsewhere costs more; capped
  double agreement = 0;  // log(1 + other nodes near it that see the same heading)
  bool verified = false;
  double log_inliers = 0;        // log(1 + inliers)
  double log_inlier_margin = 0;  // less the same of the best place elsewhere
  // Median angle between the node's and the query's rays to the same point, after removing the
  // rotation: small where the query is near relative to the room's size, large where it sees the
  // node's place from afar.
  double parallax_rad = 0;
  // Sigma of the position over the size of a place: 1 for a single view, less where the directions
  // of several views intersect.
  double sigma_spacings = 0;
};

// The default model where a layer has none of its own, for verified answers or for the others. This
// function and all below are pure; thread-safe.
AppearanceVerdict DefaultVerdict(bool verified);

// The layer's model for this kind of evidence where this program knows all of its terms, else the
// default.
AppearanceVerdict VerdictFor(const AppearanceLayer& layer, bool verified);

// The probability that a place with this evidence is right, in (0, 1), by a model for its kind.
double EstimateProbability(const AppearanceEvidence& evidence, const AppearanceVerdict& model);

// Its log odds, whose sums compare places that exclude each other.
double EstimateLogOdds(const AppearanceEvidence& evidence, const AppearanceVerdict& model);

// The probability that a panorama was taken at the first of two places that exclude each other or
// nowhere in the map, by the places' own log odds.
double ProbabilityAgainst(double log_odds, double rival_log_odds);

struct AppearanceSample {
  AppearanceEvidence evidence;
  bool right = false;
};

struct AppearanceFitOptions {
  double intercept_sigma = 5;
  double weight_sigma = 5;
  double wrong_weight = 3;
  int min_samples = 20;

  static constexpr auto Fields(const auto& use) {
    using Self = AppearanceFitOptions;
    return use(
        OptionField{"intercept_sigma", &Self::intercept_sigma, Closed(0.01, 100), "",
                    "Prior standard deviation of the intercept, around that of the default model. "
                    "Higher values trust small numbers of samples more."},
        OptionField{"weight_sigma", &Self::weight_sigma, Closed(0.01, 100), "",
                    "Prior standard deviation of each term's weight."},
        OptionField{"wrong_weight", &Self::wrong_weight, Closed(0.1, 100), "",
                    "Weight of the wrong samples relative to the right ones: a wrong answer costs "
                    "a robot more than a refused one. Higher values refuse more queries."},
        OptionField{"min_samples", &Self::min_samples, Closed(1, 10'000), "",
                    "With fewer right or fewer wrong samples than this, the default model is used. "
                    "Lower values adapt to smaller maps, but also to chance."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The most probable model (logistic regression with a normal prior around the default), fitted to
// samples of one kind. Each weight keeps the sign of its meaning: inliers, margins and agreement
// support a place; cost, parallax and the position's sigma count against it. Deterministic. Too few
// samples give the default's weights.
AppearanceVerdict FitAppearanceVerdict(std::span<const AppearanceSample> samples, bool verified,
                                       const AppearanceFitOptions& options = {});

}  // namespace waystone
