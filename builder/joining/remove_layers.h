// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>

#include "schema/map_data.h"

namespace waystone {

// What is removed from a map. All functions are thread-safe for different maps.
struct Removal {
  std::set<KeyframeId> keyframes;
  std::set<AppearanceNodeId> nodes;
  std::set<SequenceId> sequences = {};  // whole, including frames of the orientation layer only
};

// The frames of the orientation layer that are removed with these: all of a removed sequence, and
// those whose nearest keyframe or panorama of their sequence is removed. `map` still has what will
// be removed.
std::set<OrientationFrameId> FramesThatGo(const MapData& map, const Removal& removed);

// Removes nodes from the appearance layer, with their edges and poses; a layer without nodes is
// removed. No edge is made between the nodes before and after them.
void RemoveNodes(const std::set<AppearanceNodeId>& removed, MapData& map);

// Removes frames from the orientation layer, with their turns, nodes and edges. Corridors shrink to
// their remaining frames; a layer without frames is removed.
void RemoveFrames(const std::set<OrientationFrameId>& removed, MapData& map);

}  // namespace waystone
