// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "builder/build_options.h"
#include "schema/map_data.h"

// What all changes of a finished map have in common.
namespace waystone {

// "map 'kitchen'", for messages.
std::string Named(const MapData& map);

// Throws MapError(kBadRequest) for a map with layers that can't be joined or have parts removed.
void CheckLayersAreJoinable(const MapData& map);

// What a map had when some of it was about to go, for its named places.
class NamedBefore {
 public:
  explicit NamedBefore(const MapData& map);

  // Leaves of the map's named places what is left of what they held; planes that were fused are
  // what they have become. Returns the names of places of which nothing is left.
  std::vector<std::string> KeepNames(MapData& map,
                                     const std::map<PlaneId, PlaneId>& fused = {}) const;

 private:
  MapData ids_;  // and names, and nothing else
};

// What comes last: this program as the map's, the search index, and the verdict, calibrated by what
// the map holds.
void CompleteJoined(const BuildOptions& options, MapData& map);

}  // namespace waystone
