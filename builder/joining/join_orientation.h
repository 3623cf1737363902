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

// Turns a sequence's rotations, turns and corridors about the building's vertical by `turns`
// quarter turns. Thread-safe for different layers.
void TurnSequence(SequenceId sequence, int turns, OrientationLayer& layer);

// Connects the orientation layers of maps that were appended to each other. Nodes of different maps
// are compared by their stored pictures, as loops within one build are verified; where they match,
// a loop joins them. These loops and the recognised panoramas determine by how many quarter turns
// the axes of the maps differ: sequences that an edge joins are turned together into the axes of
// the first one that they are connected to. Sequences without such evidence keep their axes.
// `firsts` are the indices of the maps' first panoramas in the joined map, `maps` the first
// sequence of each. Runs on TBB's threads; deterministic.
OrientationJoin JoinOrientation(const std::vector<Recognition>& recognitions,
                                const std::vector<size_t>& firsts,
                                const std::vector<SequenceId>& maps,
                                const OrientationOptions& options, MapData& map);

}  // namespace waystone
