// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "schema/map_data.h"

namespace waystone::bench {

// A map with copies of itself added (keyframes with their landmarks, planes, edges) until it has
// `features`. Nobody can see the copies: their descriptors are made from those of the map's planes,
// half of the cells from one and half from another, mirrored or not, with noise on top. So they are
// distributed like real ones, a query's true neighbours have competitors that share half of their
// cells, and yet no two are alike. Gives the map its search index. Deterministic.
MapData Enlarged(const MapData& map, int64_t features, uint64_t seed);

}  // namespace waystone::bench
