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

// Throws MapError(kBadRequest) for maps whose layers can't become one: panoramas that are described
// in different ways, or of cameras that see other elevations.
void CheckLayersAreJoinable(const std::vector<MapData>& maps);

// The options for building more of the same: those of the map's record, but panoramas are described
// as its appearance layer says that its own are. Throws as OptionsOfRecord does.
BuildOptions OptionsOfMap(const MapData& map);

// Throws MapError(kBadRequest) for options with which nothing is built that can be joined to the
// map.
void CheckOptionsFit(const MapData& map, const BuildOptions& options);

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

// Which layers of a map changed, so that their verdicts don't hold any more.
struct ChangedLayers {
  bool planes = true;
  bool appearance = true;
};

// What comes last: this program as the map's, the search index, and the verdicts of changed layers,
// calibrated by what the map holds.
void CompleteJoined(const BuildOptions& options, const ChangedLayers& changed, MapData& map);

}  // namespace waystone
