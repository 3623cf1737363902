// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "schema/appearance_layer.h"

namespace waystone {

// What speaks for a node as the place of a panorama. Terms of AppearanceVerdict, by name:
//   "cost", "margin"                     for answers by appearance alone;
//   "log_inliers", "log_inlier_margin"   for answers that were verified by features.
struct AppearanceEvidence {
  double cost = 0;    // 0 the same view, about 1 another place
  double margin = 0;  // by how much the best place elsewhere costs more; capped
  bool verified = false;
  double log_inliers = 0;        // log(1 + inliers)
  double log_inlier_margin = 0;  // less the same of the best place elsewhere
};

// The model that holds where a layer has none of its own, for verified answers or the others.
AppearanceVerdict DefaultVerdict(bool verified);

// The layer's model where it knows all terms and is for this kind of evidence, else the default.
AppearanceVerdict VerdictFor(const AppearanceLayer& layer, bool verified);

// The probability that a place with this evidence is right, in (0, 1), by a model for its kind.
double ProbabilityOf(const AppearanceEvidence& evidence, const AppearanceVerdict& model);

struct AppearanceSample {
  AppearanceEvidence evidence;
  bool right = false;
};

struct AppearanceFitOptions {
  // Standard deviations of the model's numbers around the default's, 0.01 to 100. Larger ones trust
  // few samples more.
  double intercept_sigma = 5;
  double weight_sigma = 5;

  void Check() const;  // throws MapError(kBadOptions)
};

// The most probable model (logistic regression with a normal prior around the default), fitted to
// samples of one kind. The two classes weigh the same. Deterministic. No samples give the default.
AppearanceVerdict FitAppearanceVerdict(std::span<const AppearanceSample> samples, bool verified,
                                       const AppearanceFitOptions& options = {});

}  // namespace waystone
