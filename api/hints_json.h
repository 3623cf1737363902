// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/query.h"

namespace waystone {

// {"position": {"frame", "x", "y", "z", "radius"}, "tags": [...], "previous_map"}, each of which is
// optional, as is z. Throws MapError(kBadRequest) with the field at fault. Thread-safe, as is
// ToJson.
MapHints ReadHints(const Json& object);
Json ToJson(const MapHints& hints);

}  // namespace waystone
