// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localizer/index/map_index.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/verify_keyframe.h"
#include "localizer/verdict/deadline.h"

namespace waystone {

// Verifies the promising keyframes after the shortlisted planes were tried, until the deadline, and
// returns them, best first: those nearest to the best of the planes' places (FindPlaces), and to
// the best place's other visits that aren't near these, since planes that only look alike may have
// been fused; and, unless these settled where the query is, the shortlisted ones. None for a map
// without landmarks, which answers by its planes only. Thread-safe; deterministic except for the
// deadline.
std::vector<VerifiedKeyframe> VerifyKeyframes(const MapIndex& index, const Features& query,
                                              const Shortlist& shortlist,
                                              const std::vector<Place>& places,
                                              const PlaneQueryOptions& options,
                                              const Deadline& deadline = {});

// Gives each place the verified keyframe that shows it best, and makes places of those keyframes
// that aren't near any place. A keyframe that saw planes of a place but isn't near the place's own
// keyframe is another visit of them (a poster that hangs in two places): it becomes a place with
// the planes seen from near it, and the first one keeps those seen from near its own keyframe, or
// from near none. A place's probability is then that of its keyframe's evidence, which includes its
// planes: planes by themselves don't count missing features. Sorts: places that suffice for an
// answer before the others, most inliers first. Deterministic; thread-safe.
void JoinKeyframes(const MapIndex& index, const Features& query,
                   const std::vector<VerifiedKeyframe>& keyframes, const PlaneQueryOptions& options,
                   std::vector<Place>& places);

}  // namespace waystone
