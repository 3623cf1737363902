// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "schema/map_data.h"
#include "schema/tables/map_problem.h"

// What FindMapProblems finds in each layer; FORMAT.md lists the rules. All functions are
// thread-safe for different `problems`.
namespace waystone {

void FindPlaneProblems(const MapData& map, std::vector<MapProblem>& problems);
void FindLinkProblems(const MapData& map, std::vector<MapProblem>& problems);
void FindLookProblems(const MapData& map, std::vector<MapProblem>& problems);
void FindNameProblems(const MapData& map, std::vector<MapProblem>& problems);
void FindFloorPlanProblems(const MapData& map, std::vector<MapProblem>& problems);
// The layer must be there.
void FindAppearanceProblems(const MapData& map, std::vector<MapProblem>& problems);
void FindOrientationProblems(const MapData& map, std::vector<MapProblem>& problems);
void FindPoseProblems(const MapData& map, std::vector<MapProblem>& problems);

// Items with ids must be ordered by them.
template <class Item>
void CheckIds(const std::string& table, const std::vector<Item>& items,
              std::vector<MapProblem>& problems) {
  int64_t last = 0;
  for (const Item& item : items) {
    if (item.id.value <= last) {
      problems.push_back(
          {table + " " + std::to_string(item.id.value),
           "ids must be positive and increasing; the previous one is " + std::to_string(last)});
    }
    last = item.id.value;
  }
}

// The sequences must be ordered (CheckIds).
inline bool HasSequence(const MapData& map, SequenceId id) {
  return std::ranges::binary_search(map.sequences, id, {}, &Sequence::id);
}

}  // namespace waystone
