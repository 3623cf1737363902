// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// A map in memory, ready for queries. Immutable after Build, so any number of threads may share it.
class MapIndex {
 public:
  // Throws MapError(kMapDamaged) for a map whose parts don't refer to each other properly.
  static std::shared_ptr<const MapIndex> Build(MapData map);

  const MapData& map() const { return map_; }
  // Nothing for an id that isn't in the map.
  const Plane* FindPlane(PlaneId id) const;
  const Keyframe* FindKeyframe(KeyframeId id) const;
  // Ids of the planes with an edge to `id`, ascending.
  const std::vector<PlaneId>& Neighbours(PlaneId id) const;

 private:
  explicit MapIndex(MapData map);

  MapData map_;
  std::unordered_map<PlaneId, int> plane_index_;
  std::unordered_map<KeyframeId, int> keyframe_index_;
  std::vector<std::vector<PlaneId>> neighbours_;
};

}  // namespace waystone
