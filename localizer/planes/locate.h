// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/features/features.h"
#include "localizer/index/map_index.h"
#include "localizer/planes/plane_query_options.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/deadline.h"

namespace waystone {

// How the features of a map's queries are extracted: as the map's own, from a working image with no
// more pixels than the map's largest keyframe has, so that tolerances in px mean the same in both.
// Pure; thread-safe.
FeatureOptions QueryFeatureOptions(const MapIndex& index, const PlaneQueryOptions& options);

// Localizes the image with these features by a map's planes: shortlist, homographies, places,
// verdict, with times. The features are of the map's type (WS_CHECK). `explain` adds
// PlaneAnswer::explanation. Pixels of the query are those of the features. Names and map are the
// caller's. Thread-safe; deterministic except for the deadline.
Answer LocateByPlanes(const MapIndex& index, const Features& query,
                      const PlaneQueryOptions& options, const Deadline& deadline, bool explain);

// Converts an answer from pixels of the features to those of the given image. Pure; thread-safe.
void ToImagePixels(const Features& query, PlaneAnswer& answer);

}  // namespace waystone
