// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/joining/join_frames.h"
#include "builder/orientation/options.h"
#include "schema/map_data.h"

namespace waystone {

// What joining orientation layers did.
struct OrientationJoin {
  int loops = 0;             // between nodes of different maps
  int sequences_turned = 0;  // by quarter turns, into the axes of the first
};

// A quarter turn about the building's vertical, `turns` times, of all that a sequence's rotations,
// turns and corridors say.
void TurnSequence(SequenceId sequence, int turns, OrientationLayer& layer);

// Ties the orientation layers of maps that were appended one to the other together. Nodes of
// different maps are compared by the pictures that they keep, as loops within one build are
// verified; where they meet, a loop joins them. These loops and the panoramas that were recognised
// say by how many quarter turns the axes of the maps differ: sequences that an edge joins are
// turned together into the axes of the first that they are tied to. Those that nothing is known of
// keep theirs. `firsts` are the places of the maps' first panoramas in the joined map, `maps` the
// first sequence of each. Runs on TBB's threads; deterministic.
OrientationJoin JoinOrientation(const std::vector<Recognition>& recognitions,
                                const std::vector<size_t>& firsts,
                                const std::vector<SequenceId>& maps,
                                const OrientationOptions& options, MapData& map);

}  // namespace waystone
