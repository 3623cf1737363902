// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "schema/file/map_store.h"
#include "schema/map_data.h"

// What FindMapProblems says of the layers beside the planes; FORMAT.md lists the rules.
namespace waystone {

void FindAppearanceProblems(const MapData& map, std::vector<MapProblem>& problems);
void FindOrientationProblems(const MapData& map, std::vector<MapProblem>& problems);

inline void FindLayerProblems(const MapData& map, std::vector<MapProblem>& problems) {
  if (map.appearance) FindAppearanceProblems(map, problems);
  if (map.orientation) FindOrientationProblems(map, problems);
}

inline bool HasSequence(const MapData& map, SequenceId id) {
  return std::any_of(map.sequences.begin(), map.sequences.end(),
                     [&](const Sequence& sequence) { return sequence.id == id; });
}

}  // namespace waystone
