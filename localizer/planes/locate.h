// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/features/features.h"
#include "localizer/index/map_index.h"
#include "localizer/planes/plane_query_options.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/deadline.h"

namespace waystone {

// Where was the image with these features taken, by a map's planes? Shortlist, homographies,
// places, verdict, with times. The features are of the map's type (WS_CHECK). `explain` adds
// PlaneAnswer::explanation. Names and map are the caller's. Thread-safe, deterministic but for the
// deadline.
Answer LocateByPlanes(const MapIndex& index, const Features& query,
                      const PlaneQueryOptions& options, const Deadline& deadline, bool explain);

}  // namespace waystone
