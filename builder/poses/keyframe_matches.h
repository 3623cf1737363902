// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "builder/frames/progress.h"
#include "builder/planes/keyframe_sample.h"
#include "core/base/options.h"
#include "core/features/match.h"
#include "core/two_view/fundamental.h"
#include "localizer/index/map_index.h"

namespace waystone {

// Matches of two images that fit one epipolar geometry.
struct VerifiedMatches {
  std::vector<std::pair<int, int>> features;  // of a and of b
  EpipolarFit fit;                            // of all matches, before it dropped the others
};

// Nothing where no geometry fits. Deterministic; thread-safe.
std::optional<VerifiedMatches> MatchImages(const Features& a, const Features& b,
                                           const MatchOptions& match,
                                           const EpipolarOptions& epipolar);

struct KeyframeMatchOptions {
  int neighbours = 8;
  int revisits = 20;
  int min_inliers = 15;
  MatchOptions match;
  EpipolarOptions epipolar;

  static constexpr auto Fields() {
    using Self = KeyframeMatchOptions;
    return std::tuple{
        OptionField{"neighbours", &Self::neighbours, Closed(1, 1000), "",
                    "Keyframes before and after that each one is matched with."},
        OptionField{"revisits", &Self::revisits, Closed(1, 1000), "",
                    "Keyframes anywhere in the map that each one is matched with: those that share "
                    "most of its planes and landmarks."},
        OptionField{"min_inliers", &Self::min_inliers, Closed(8, 10'000), "",
                    "Fewest matches that two keyframes keep."},
        OptionGroup{"match", &Self::match}, OptionGroup{"epipolar", &Self::epipolar}};
  }
  void Check() const { CheckFields("keyframe_matches", *this); }  // throws MapError(kBadOptions)
};

// Two keyframes that show the same, as indices in the map's keyframes.
struct MatchedKeyframes {
  int a = 0;  // < b
  int b = 0;
  VerifiedMatches matches;
};

// Matches all keyframes of a map, `features` being theirs (ReadKeyframes), with those beside them
// and with those that the map itself proposes for them (VoteForPlaces), so that loops close.
// Ordered by (a, b). Deterministic on any number of threads. Throws MapError: kBadOptions;
// kInterrupted.
std::vector<MatchedKeyframes> MatchKeyframes(const MapIndex& index,
                                             const std::vector<SampledKeyframe>& features,
                                             const KeyframeMatchOptions& options,
                                             const ProgressCallback& progress = {});

}  // namespace waystone
