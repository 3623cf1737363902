// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "builder/appearance/options.h"
#include "builder/joining/join_frames.h"
#include "schema/map_data.h"

namespace waystone {

// A loop between panoramas of two maps, by their indices in the list of maps and of nodes. The edge
// is that from a to b, without ids yet.
struct NodeTie {
  size_t map_a = 0;
  size_t node_a = 0;
  size_t map_b = 0;
  size_t node_b = 0;
  AppearanceEdge edge;
};

// Brings the appearance layers of all maps into one frame: what recognitions connect is placed
// where most of them agree, in the unit of the first map, and all poses are optimised with the
// original layers and the ties. Panoramas with poses keep them; the others follow. What nothing
// connects is laid out below the rest, as a part of its own. Areas of named places move with their
// panoramas on maps without poses. Returns the ties that fit the graph.
// Throws MapError(kBadRequest) for panoramas without poses that can't be put into the frame of
// those with poses. Deterministic; thread-safe for different maps.
std::vector<NodeTie> JoinAppearance(const std::vector<Recognition>& recognitions,
                                    const AppearanceOptions& options, std::vector<MapData>& maps);

// Adds these ties to the joined map, in which the nodes of each map are consecutive from its index
// in `firsts` on.
void AddTies(const std::vector<NodeTie>& ties, const std::vector<size_t>& firsts, MapData& map);

}  // namespace waystone
