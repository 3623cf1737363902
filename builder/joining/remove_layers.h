// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>

#include "schema/map_data.h"

namespace waystone {

// What is removed from a map.
struct Removal {
  std::set<KeyframeId> keyframes;
  std::set<AppearanceNodeId> nodes;
  std::set<SequenceId> sequences = {};  // whole: what only the orientation layer has of them, too
};

// The frames of the orientation layer that go with these: all of a sequence that goes, and those
// whose nearest keyframe or panorama of their sequence goes. The map still has what is removed.
std::set<OrientationFrameId> FramesThatGo(const MapData& map, const Removal& removed);

// Takes nodes out of the appearance layer, with their edges, poses included; a layer without nodes
// goes. What was before and after them isn't joined anew.
void RemoveNodes(const std::set<AppearanceNodeId>& removed, MapData& map);

// Takes frames out of the orientation layer, with their turns, nodes and edges. Corridors end where
// their last frame is left; a layer without frames goes.
void RemoveFrames(const std::set<OrientationFrameId>& removed, MapData& map);

}  // namespace waystone
