// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "builder/frames/progress.h"
#include "builder/planes/keyframe_sample.h"
#include "core/features/match.h"
#include "core/two_view/fundamental.h"
#include "localizer/index/map_index.h"

namespace waystone {

// Matches of two images that fit one epipolar geometry.
struct VerifiedMatches {
  std::vector<std::pair<int, int>> features;  // of a and of b
  EpipolarFit fit;                            // to all matches, including those that it dropped
};

// Nothing where no geometry fits. Deterministic; thread-safe.
std::optional<VerifiedMatches> MatchImages(const Features& a, const Features& b,
                                           const MatchOptions& match,
                                           const EpipolarOptions& epipolar);

// Two keyframes that show the same, as indices in the map's keyframes.
struct MatchedKeyframes {
  int a = 0;  // < b
  int b = 0;
  VerifiedMatches matches;
};

// Matches all keyframes of a map, whose features are `features` (ReadKeyframes), with the 8 before
// and after them in their stretch, and with the 20 that the map itself proposes for them
// (VoteForPlaces), so that loops close. Pairs with fewer than 15 matches are left out.
// Ordered by (a, b). Deterministic on any number of threads. Throws MapError(kInterrupted).
std::vector<MatchedKeyframes> MatchKeyframes(const MapIndex& index,
                                             const std::vector<SampledKeyframe>& features,
                                             const ProgressCallback& progress = {});

}  // namespace waystone
