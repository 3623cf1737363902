// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/base/options.h"
#include "core/features/features.h"
#include "core/features/match.h"
#include "core/homography/find_plane.h"
#include "core/homography/homology.h"
#include "core/two_view/fundamental.h"
#include "localizer/verdict/gates.h"

namespace waystone {

// How a perspective photo is searched for among a map's planes.
struct PlaneQueryOptions {
  int max_features = 1000;
  double contrast_threshold = 0.005;
  int votes_per_feature = 3;
  int neighbours = 8;
  int probes = 64;
  int max_candidates = 16;
  int settled_inliers = 30;
  double settled_share = 0.5;
  int min_votes = 6;
  MatchOptions match{0.85, true};
  // A wider bound than for building, since a query's camera may differ, and fewer samples: most
  // planes that are tried are wrong, and those cost the most.
  LocalRansacOptions ransac{.max_error_px = 3.0, .max_samples = 500};
  HomologyOptions homology;
  GateOptions gates;
  int max_keyframes = 4;
  MatchOptions keyframe_match{0.85, true};
  EpipolarOptions epipolar;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    using Self = PlaneQueryOptions;
    return use(
        OptionField{"max_features", &Self::max_features, Closed(50, 20'000), "",
                    "Maximum number of features of a query. More features find more places, but "
                    "take longer."},
        OptionField{"contrast_threshold", &Self::contrast_threshold, Open(0, 1), "",
                    "The same as for the build: lower values find fainter features."},
        OptionField{"votes_per_feature", &Self::votes_per_feature, Closed(1, 1000), "",
                    "Number of nearest map features for which a query feature votes. Higher values "
                    "find planes in poor views, but try more wrong ones."},
        OptionField{"neighbours", &Self::neighbours, Closed(2, 1000), "",
                    "Number of nearest map features by which a query feature weights its votes for "
                    "keyframes: the farthest one is what any feature would find by chance.",
                    OptionUse::kInternal},
        OptionField{
            "probes", &Self::probes, AtLeast(1), "",
            "Number of lists of the map's search index that are searched. More lists find more of "
            "the true nearest features, but take longer; searching all lists is exact."},
        OptionField{"max_candidates", &Self::max_candidates, AtLeast(1), "",
                    "Number of planes whose homography is tried, most votes first. More planes "
                    "find more places, at about 1 ms each."},
        OptionField{"settled_inliers", &Self::settled_inliers, AtLeast(1), "",
                    "A plane with this many distinct inliers settles the place of the query. Lower "
                    "values answer faster, but may miss an ambiguity."},
        OptionField{"settled_share", &Self::settled_share, AtLeast(0), "",
                    "Once a plane has settled the place, planes elsewhere are tried only if their "
                    "votes are at least this share of its inliers; at most ambiguous_share. 0 "
                    "tries all planes, which is slowest on large maps."},
        OptionField{"min_votes", &Self::min_votes, AtLeast(1), "",
                    "Planes with fewer votes are not tried."},
        OptionGroup{"match", &Self::match}, OptionGroup{"ransac", &Self::ransac},
        OptionGroup{"homology", &Self::homology}, OptionGroup{"gates", &Self::gates},
        OptionField{
            "max_keyframes", &Self::max_keyframes, AtLeast(1), "",
            "Number of keyframes verified by all their matches: this many each for the places that "
            "planes agree on, for other visits to the best of these, and for the keyframes with "
            "the most votes beyond chance. More keyframes find more places, at about 2 ms each."},
        OptionGroup{"keyframe_match", &Self::keyframe_match},
        OptionGroup{"epipolar", &Self::epipolar},
        OptionField{"seed", &Self::seed, AnyValue(), "",
                    "Random seed: the same query, map and options give the same answer."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
