// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/map_data.h"

namespace waystone {

// The sequences of the orientation layer in which corridors can't be distinguished from rooms, in
// the map's order: those that don't see all around (SeesAllAround). Empty without the layer. Pure;
// thread-safe.
std::vector<SequenceId> ListSequencesWithUnknownCorridors(const MapData& map);

}  // namespace waystone
