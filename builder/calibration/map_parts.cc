// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/map_parts.h"

namespace waystone {

MapData CopyPlanes(const MapData& map) {
  MapData part;
  part.info = map.info;
  part.sequences = map.sequences;
  part.planes = map.planes;
  part.edges = map.edges;
  part.links = map.links;
  part.index = map.index;
  part.verdict = map.verdict;
  part.poses = map.poses;
  part.keyframes.reserve(map.keyframes.size());
  for (const Keyframe& keyframe : map.keyframes) {
    part.keyframes.push_back(keyframe);
    part.keyframes.back().picture = std::vector<uint8_t>();  // frees it, unlike clear()
  }
  return part;
}

MapData CopyPanoramas(const MapData& map) {
  MapData part;
  part.info = map.info;
  part.sequences = map.sequences;
  part.appearance = map.appearance;
  part.poses = map.poses;
  for (AppearanceNode& node : part.appearance->nodes) node.picture = std::vector<uint8_t>();
  return part;
}

}  // namespace waystone
