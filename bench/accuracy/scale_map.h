// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "schema/map_data.h"

namespace waystone::bench {

// A copy of a map with planes added that nobody can see, until it has `features` of them: each has
// the keypoints of one of the map's own planes and a single view. Their descriptors are made from
// the map's: half of the cells of one and half of another, mirrored or not, with noise on top. So
// they are distributed as real ones are, a query's true neighbours have competitors that share half
// of their cells, and still no two are alike. Gives the map its search index. Deterministic.
MapData Enlarged(const MapData& map, int64_t features, uint64_t seed);

}  // namespace waystone::bench
