// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localizer/index/map_index.h"
#include "localizer/planes/plane_query_options.h"

namespace waystone {

// A plane that the query may show.
struct ShortlistedPlane {
  int plane = 0;  // index in the map's planes
  int votes = 0;
};

// Planes by descriptor votes, most votes first, at most options.max_candidates of them. Every query
// feature votes once for each plane among its nearest descriptors.
std::vector<ShortlistedPlane> ShortlistPlanes(const MapIndex& index, const Features& query,
                                              const PlaneQueryOptions& options);

}  // namespace waystone
