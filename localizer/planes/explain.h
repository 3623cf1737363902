// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/features/features.h"
#include "localizer/map_index.h"
#include "localizer/options.h"
#include "localizer/planes/explanation.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/verify.h"

namespace waystone {

// What became of every shortlisted plane, of which `tried` is what TryPlanes made with the same
// options. Groups the places anew, which costs well under a millisecond. Deterministic.
Explanation Explain(const MapIndex& index, const Features& query,
                    const std::vector<ShortlistedPlane>& shortlist,
                    const std::vector<VerifiedPlane>& tried, const LocalizeOptions& options);

}  // namespace waystone
