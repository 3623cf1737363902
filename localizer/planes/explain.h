// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/features/features.h"
#include "localizer/index/map_index.h"
#include "localizer/planes/plane_query_options.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/verify.h"
#include "localizer/verdict/explanation.h"

namespace waystone {

// What became of every shortlisted plane, of which `tried` is what TryPlanes made with the same
// options. Groups the places anew, which costs well under a millisecond. Deterministic.
Explanation Explain(const MapIndex& index, const Features& query,
                    const std::vector<ShortlistedPlane>& shortlist,
                    const std::vector<VerifiedPlane>& tried, const PlaneQueryOptions& options);

}  // namespace waystone
