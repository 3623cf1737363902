// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/index/map_index.h"

namespace waystone {

// A whole map at a glance, for drawing: by columns, so that 10,000 planes are some 500 KB. Fields:
//   layers     the layers that the map has: "planes", "appearance", "orientation", "poses"
//   keyframes  id, sequence (id), stretch, frame, planes (seen there), features (in view on them)
//   planes     id, reference, stretch (of the reference), features, keyframes (a list for each)
//   edges      a, b, third_eigenvalue
Json OverviewJson(const MapIndex& index);

// The field layers of the above.
Json LayersJson(const MapData& map);

}  // namespace waystone
