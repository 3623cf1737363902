// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/index/map_index.h"

namespace waystone {

// A whole map at a glance, for drawing: the schema Overview of clients/openapi.yaml. By columns, so
// that 10,000 planes take some 500 KB. Both functions are thread-safe.
Json OverviewJson(const MapIndex& index);

// The layers that a map has: "planes", "appearance", "orientation", "poses".
Json LayersJson(const MapData& map);

}  // namespace waystone
