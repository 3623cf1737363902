// SPDX-License-Identifier: Apache-2.0
#include "quality/place_id.h"

#include <algorithm>

#include "core/base/check.h"

namespace waystone {

const std::string& SourceOf(const MapIndex& index, const PlaceId& place) {
  if (place.layer == PlaceLayer::kPlanes) {
    const Keyframe* keyframe = index.FindKeyframe(KeyframeId{place.id});
    WS_CHECK(keyframe != nullptr, "the map has no such keyframe");
    return keyframe->source;
  }
  const std::vector<AppearanceNode>& nodes = index.map().appearance->nodes;
  const auto node =
      std::ranges::lower_bound(nodes, AppearanceNodeId{place.id}, {}, &AppearanceNode::id);
  WS_CHECK(node != nodes.end() && node->id.value == place.id, "the map has no such panorama");
  return node->source;
}

}  // namespace waystone
