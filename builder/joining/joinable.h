// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "builder/build_options.h"
#include "schema/map_data.h"

// What all changes of a finished map have in common.
namespace waystone {

// "map 'kitchen'", for messages.
std::string Named(const MapData& map);

// Throws MapError(kBadRequest) for a map with layers that can't be joined or have parts removed.
void CheckLayersAreJoinable(const MapData& map);

// What comes last: this program as the map's, the search index, and the verdict, calibrated by what
// the map holds.
void CompleteJoined(const BuildOptions& options, MapData& map);

}  // namespace waystone
