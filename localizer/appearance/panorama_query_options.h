// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/options.h"
#include "core/features/match.h"
#include "core/panorama/visual_compass.h"
#include "core/two_view/relative_rotation.h"
#include "localizer/appearance/panorama_features.h"

namespace waystone {

// How a panorama or a photo is searched for among a map's panoramas.
struct PanoramaQueryOptions {
  int candidates = 8;
  int verified_candidates = 16;
  double phase_weight = 0.5;
  // Few frequencies: nearby places agree only in these.
  PhaseCompassOptions phases{.frequencies = 12, .steps = 128};
  bool fine_heading = true;
  CompassOptions compass;
  double phase_sigma_rad = 0.3;
  bool verify = true;
  double settled_probability = 0.99;
  PanoramaFeatureOptions features;
  MatchOptions match{0.8, true};
  int max_poses = 4;
  int photo_features = 1500;
  int photo_neighbours = 20;
  int photo_probes = 8;
  int photo_candidates = 64;
  int photo_poses = 10;
  int photo_witnesses = 2;
  double photo_agreement_rad = 0.06;
  // For a few candidates that already look alike, and a verdict that weighs more evidence than
  // this.
  RelativeOptions relative{.max_samples = 200, .max_log10_chance = -1};
  double interpolation_cost = 0.1;
  double direction_sigma_rad = 0.03;
  double elsewhere_spacings = 4;
  double max_margin = 0.3;
  double agreement_rad = 0.25;
  double min_probability = 0.9;

  static constexpr auto Fields(const auto& use) {
    using Self = PanoramaQueryOptions;
    return use(
        OptionField{"candidates", &Self::candidates, Closed(1, 1000), "",
                    "Number of nodes compared by their phases, nearest signature first. More nodes "
                    "find more places, but take longer."},
        OptionField{"verified_candidates", &Self::verified_candidates, Closed(1, 1000), "",
                    "The same as candidates, if the candidates are verified by their features, "
                    "which takes most of the time."},
        OptionField{"phase_weight", &Self::phase_weight, Closed(0, 10), "",
                    "Weight of the phases' disagreement (0 to 1) relative to the distance of the "
                    "signatures. Higher values favour nodes with the same view; lower values "
                    "tolerate more motion."},
        OptionGroup{"phases", &Self::phases},
        OptionField{
            "fine_heading", &Self::fine_heading, AnyValue(), "",
            "Whether to refine the heading by the warping search, which takes a few ms. Otherwise "
            "it comes from the phases, which are exact only for a pure rotation."},
        OptionGroup{"compass", &Self::compass},
        OptionField{"phase_sigma_rad", &Self::phase_sigma_rad, Closed(0.001, 3), "rad",
                    "Standard deviation of the phases' heading without refinement."},
        OptionField{"verify", &Self::verify, AnyValue(), "",
                    "Whether to verify candidates by features if the nodes have any. Costs the "
                    "time of the feature extraction."},
        OptionField{
            "settled_probability", &Self::settled_probability, Closed(0.5, 1), "",
            "An answer by appearance alone with at least this probability is not verified; 1 "
            "verifies all answers. Lower values answer faster and trust appearance more."},
        OptionGroup{"features", &Self::features}, OptionGroup{"match", &Self::match},
        OptionGroup{"relative", &Self::relative},
        OptionField{"max_poses", &Self::max_poses, Closed(1, 1000), "",
                    "Number of candidates whose relative pose is estimated, most matches first."},
        OptionField{"photo_features", &Self::photo_features, Closed(10, 100'000), "",
                    "Maximum number of features of a perspective photo. More features match more "
                    "of the nodes' features."},
        OptionField{"photo_neighbours", &Self::photo_neighbours, Closed(2, 1000), "",
                    "Number of nearest map features of each photo feature, for whose nodes it "
                    "votes: about as many as there are nodes that see the same place. Higher "
                    "values find more places, but take longer."},
        OptionField{"photo_probes", &Self::photo_probes, Closed(1, 32768), "",
                    "Number of lists of the node features' index that are searched for each photo "
                    "feature."},
        OptionField{"photo_candidates", &Self::photo_candidates, Closed(1, 10'000), "",
                    "Number of nodes matched with the photo, most votes first. More nodes find "
                    "more places, at about 1 ms each."},
        OptionField{"photo_poses", &Self::photo_poses, Closed(1, 1000), "",
                    "Number of photo_candidates whose relative pose is estimated; max_poses if "
                    "that is larger.",
                    OptionUse::kInternal},
        OptionField{"photo_witnesses", &Self::photo_witnesses, Closed(1, 100), "",
                    "Number of nodes that must agree on the photo's heading.",
                    OptionUse::kInternal},
        OptionField{
            "photo_agreement_rad", &Self::photo_agreement_rad, Closed(0.001, 1), "rad",
            "Two nodes agree on a photo's heading if their headings differ by at most this.",
            OptionUse::kInternal},
        OptionField{"interpolation_cost", &Self::interpolation_cost, Closed(0.001, 10), "",
                    "Difference in cost at which a neighbour's weight for the position is e times "
                    "lower. Higher values interpolate more widely."},
        OptionField{"direction_sigma_rad", &Self::direction_sigma_rad, Closed(0.001, 1), "rad",
                    "Standard deviation of a direction between two panoramas. Higher values trust "
                    "the nodes' positions more."},
        OptionField{"elsewhere_spacings", &Self::elsewhere_spacings, Closed(1, 1000), "",
                    "Nodes farther apart than this are different places."},
        OptionField{"max_margin", &Self::max_margin, Closed(0.001, 10), "",
                    "Margins of appearance are capped at this."},
        OptionField{"agreement_rad", &Self::agreement_rad, Closed(0.01, 3), "rad",
                    "Two nodes agree on a panorama's heading if their headings differ by at most "
                    "this. Higher values accept more chance agreement."},
        OptionField{
            "min_probability", &Self::min_probability, Closed(1e-6, 1 - 1e-6), "",
            "Minimum probability of a localized answer. Higher values refuse more queries."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
