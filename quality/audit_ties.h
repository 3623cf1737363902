// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "quality/audit.h"
#include "quality/audit_views.h"

namespace waystone {

// Visits that only one plane connects: internal to quality. Pure; thread-safe.
std::vector<LoneTie> FindLoneTies(const MapIndex& index, const std::vector<KeyframeView>& views);

}  // namespace waystone
