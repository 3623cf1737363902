// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "schema/map_data.h"

namespace waystone {

// The number of features of all planes and landmarks of all keyframes. Pure; thread-safe.
int64_t CountFeatures(const MapData& map);

// The search index over the descriptors of all planes, plane after plane, and of all landmarks,
// keyframe after keyframe, as MapData::index holds it: nothing for a map with so few that they are
// searched one by one. Deterministic, on any number of threads.
std::optional<InvertedFile> IndexFeatures(const MapData& map,
                                          const InvertedFileOptions& options = {});

}  // namespace waystone
