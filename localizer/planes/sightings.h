// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localizer/index/map_index.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/verify_keyframe.h"
#include "localizer/verdict/deadline.h"

namespace waystone {

// The keyframes that are worth verifying after the shortlisted planes were tried, verified, best
// first, until the deadline: those nearest to the best of the planes' places (FindPlaces), and
// to the best place's other visits, which aren't near these, since planes may be fused that only
// look alike; and unless these settled where the query is, the shortlisted ones. None for a map
// without landmarks, which is answered by its planes alone.
std::vector<VerifiedKeyframe> VerifyKeyframes(const MapIndex& index, const Features& query,
                                              const Shortlist& shortlist,
                                              const std::vector<Place>& places,
                                              const PlaneQueryOptions& options,
                                              const Deadline& deadline = {});

// Gives each place the verified keyframe that shows it best, and makes places of those keyframes
// that no place is near. A keyframe that saw planes of a place but isn't near the place's own one
// is another visit of them (a poster that hangs in two places): it becomes a place with what was
// seen from near it, and the first one keeps what was seen from near its own keyframe, or from near
// none. A place's probability is then that of its keyframe's evidence, of which its planes are a
// part: what planes give alone doesn't count what is missing. Sorts: places that suffice for an
// answer before the others, most inliers first.
void JoinKeyframes(const MapIndex& index, const Features& query,
                   const std::vector<VerifiedKeyframe>& keyframes, const PlaneQueryOptions& options,
                   std::vector<Place>& places);

}  // namespace waystone
