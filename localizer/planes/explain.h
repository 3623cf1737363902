// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/features/features.h"
#include "localizer/index/map_index.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/plane_query_options.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/verify.h"
#include "localizer/planes/verify_keyframe.h"
#include "localizer/verdict/explanation.h"

namespace waystone {

// What became of every shortlisted plane and verified keyframe: `tried` and `keyframes` are what
// TryPlanes and VerifyKeyframes made with the same options, `places` what Decide was given.
// Deterministic; thread-safe.
Explanation Explain(const MapIndex& index, const Features& query, const Shortlist& shortlist,
                    const std::vector<VerifiedPlane>& tried,
                    const std::vector<VerifiedKeyframe>& keyframes,
                    const std::vector<Place>& places, const PlaneQueryOptions& options);

}  // namespace waystone
