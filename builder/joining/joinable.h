// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "builder/build_options.h"
#include "schema/map_data.h"

// What all changes of a finished map have in common. Functions are thread-safe for different maps.
namespace waystone {

// "map 'kitchen'", for messages.
std::string Named(const MapData& map);

// Throws MapError(kBadRequest) for maps whose layers can't become one: panoramas that are described
// in different ways, or of cameras that see other elevations.
void CheckLayersAreJoinable(const std::vector<MapData>& maps);

// The options for extending the map: those of its record, but with panoramas described as its
// appearance layer states. Throws as OptionsOfRecord does.
BuildOptions OptionsOfMap(const MapData& map);

// Throws MapError(kBadRequest) for options whose builds can't be joined to the map.
void CheckOptionsFit(const MapData& map, const BuildOptions& options);

// What a map had before some of it is removed, for its named places. Immutable after construction.
class NamedBefore {
 public:
  explicit NamedBefore(const MapData& map);

  // Reduces the map's named places to those of their contents that are left; fused planes count as
  // the ones that they were fused into. Returns the names of places of which nothing is left.
  std::vector<std::string> KeepNames(MapData& map,
                                     const std::map<PlaneId, PlaneId>& fused = {}) const;

 private:
  MapData ids_;  // ids and names only
};

// Which layers of a map changed, so that their verdicts don't hold any more.
struct ChangedLayers {
  bool planes = true;
  bool appearance = true;
};

// The last steps: sets this program as the map's, makes the search index, and calibrates the
// verdicts of changed layers by what the map holds.
void CompleteJoined(const BuildOptions& options, const ChangedLayers& changed, MapData& map);

}  // namespace waystone
