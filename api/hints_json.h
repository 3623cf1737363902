// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/query.h"

namespace waystone {

// {"position": {"frame", "x", "y", "z", "radius"}, "tags": [...], "previous_map"}, each of which
// may be left out, as z may. Throws MapError(kBadRequest) with the field at fault.
MapHints ReadHints(const Json& object);
Json ToJson(const MapHints& hints);

}  // namespace waystone
