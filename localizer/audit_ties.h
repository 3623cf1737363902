// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localizer/audit.h"
#include "localizer/audit_views.h"

namespace waystone {

// Visits that one plane alone ties to each other: inside localizer/audit only. Pure.
std::vector<LoneTie> FindLoneTies(const MapIndex& index, const std::vector<KeyframeView>& views);

}  // namespace waystone
