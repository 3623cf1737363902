// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tuple>

#include "core/base/options.h"
#include "core/features/match.h"
#include "core/panorama/visual_compass.h"
#include "core/two_view/relative_rotation.h"
#include "localizer/appearance/panorama_features.h"

namespace waystone {

// How a panorama, or a photo, is looked for among a map's panoramas.
struct PanoramaQueryOptions {
  int candidates = 8;
  int verified_candidates = 16;
  double phase_weight = 0.5;
  // Few frequencies: places near each other agree in these alone.
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
  RelativeOptions relative{.max_samples = 200};
  double interpolation_cost = 0.1;
  double direction_sigma_rad = 0.03;
  double elsewhere_spacings = 4;
  double max_margin = 0.3;
  double agreement_rad = 0.25;
  double min_probability = 0.9;

  static constexpr auto Fields() {
    using Self = PanoramaQueryOptions;
    return std::tuple{
        OptionField{"candidates", &Self::candidates, Closed(1, 1000), "",
                    "Nodes that are compared by their phases, nearest signature first. More find "
                    "more places and cost time."},
        OptionField{"verified_candidates", &Self::verified_candidates, Closed(1, 1000), "",
                    "The same where candidates are verified by their features, which takes most of "
                    "the time."},
        OptionField{
            "phase_weight", &Self::phase_weight, Closed(0, 10), "",
            "Weight of the phases' disagreement (0 to 1) beside the signatures' distance. "
            "More trusts what is seen at the same height and angle; less tolerates motion."},
        OptionGroup{"phases", &Self::phases},
        OptionField{"fine_heading", &Self::fine_heading, AnyValue(), "",
                    "Refine the heading by the warping search, which takes a few ms. Without "
                    "it, the phases give it, exactly for a pure turn alone."},
        OptionGroup{"compass", &Self::compass},
        OptionField{"phase_sigma_rad", &Self::phase_sigma_rad, Closed(0.001, 3), "rad",
                    "Standard deviation of the phases' heading where it isn't refined."},
        OptionField{"verify", &Self::verify, AnyValue(), "",
                    "Verify candidates by features where the nodes have some. Costs the "
                    "extraction."},
        OptionField{"settled_probability", &Self::settled_probability, Closed(0.5, 1), "",
                    "An answer by appearance alone that is as probable isn't verified; 1 verifies "
                    "all. Lower answers faster and trusts the appearance more."},
        OptionGroup{"features", &Self::features},
        OptionGroup{"match", &Self::match},
        OptionGroup{"relative", &Self::relative},
        OptionField{"max_poses", &Self::max_poses, Closed(1, 1000), "",
                    "Candidates whose relative pose is estimated, most matches first."},
        OptionField{"photo_features", &Self::photo_features, Closed(10, 100'000), "",
                    "Features of a perspective photo. More match more of what nodes keep."},
        OptionField{"photo_neighbours", &Self::photo_neighbours, Closed(2, 1000), "",
                    "Each of them votes for the nodes of so many nearest features: as many as see "
                    "a place together. More find more and take longer."},
        OptionField{"photo_probes", &Self::photo_probes, Closed(1, 32768), "",
                    "Lists of the node features' index that are searched for them."},
        OptionField{"photo_candidates", &Self::photo_candidates, Closed(1, 10'000), "",
                    "Nodes that the photo is matched with, most votes first. More find more places "
                    "and cost about 1 ms each."},
        OptionField{"photo_poses", &Self::photo_poses, Closed(1, 1000), "",
                    "Of these, nodes whose relative pose is estimated; max_poses where that is "
                    "more.",
                    OptionUse::kInternal},
        OptionField{"photo_witnesses", &Self::photo_witnesses, Closed(1, 100), "",
                    "Nodes that must agree on the photo's heading.", OptionUse::kInternal},
        OptionField{"photo_agreement_rad", &Self::photo_agreement_rad, Closed(0.001, 1), "rad",
                    "Headings of a photo that two nodes see agree within this.",
                    OptionUse::kInternal},
        OptionField{"interpolation_cost", &Self::interpolation_cost, Closed(0.001, 10), "",
                    "Cost by which a neighbour counts e times less for the position. More "
                    "interpolates more widely."},
        OptionField{"direction_sigma_rad", &Self::direction_sigma_rad, Closed(0.001, 1), "rad",
                    "Standard deviation of a direction between two panoramas. More trusts the "
                    "nodes' positions instead."},
        OptionField{"elsewhere_spacings", &Self::elsewhere_spacings, Closed(1, 1000), "",
                    "Nodes farther apart than so many spacings are different places."},
        OptionField{"max_margin", &Self::max_margin, Closed(0.001, 10), "",
                    "A margin of appearance beyond this counts no more."},
        OptionField{"agreement_rad", &Self::agreement_rad, Closed(0.01, 3), "rad",
                    "Headings of a panorama that two nodes see agree within this. More lets chance "
                    "support a place."},
        OptionField{"min_probability", &Self::min_probability, Closed(1e-6, 1 - 1e-6), "",
                    "Probability from which on the answer is localized. Higher refuses more."}};
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
