// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/joining/merge_maps.h"

namespace waystone {

// The maps of the overlapping parts of one walk, in their order, as one map: MergeMaps of them. A
// part whose pictures are all in a neighbour's map adds nothing and is left out, as where the
// camera stood still. If one part is left, it is the map. Deterministic, on any number of threads.
// Throws as MergeMaps does.
JoinResult JoinParts(std::vector<MapData> parts, const std::string& name,
                     const BuildOptions& options);

}  // namespace waystone
