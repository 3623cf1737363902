// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <string>

#include "localizer/index/map_index.h"
#include "localizer/verdict/answered_place.h"

namespace waystone {

// A place of a map, of either layer: a keyframe or a panorama.
struct PlaceId {
  PlaceLayer layer = PlaceLayer::kPlanes;
  int64_t id = 0;

  auto operator<=>(const PlaceId&) const = default;
};

inline PlaceId PlaceIdOf(KeyframeId id) { return {PlaceLayer::kPlanes, id.value}; }
inline PlaceId PlaceIdOf(AppearanceNodeId id) { return {PlaceLayer::kAppearance, id.value}; }

// The name of its image. The map has the place (WS_CHECK). Pure; thread-safe.
const std::string& SourceOf(const MapIndex& index, const PlaceId& place);

}  // namespace waystone
