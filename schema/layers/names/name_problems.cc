// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/base/text.h"
#include "schema/layers/layer_problems.h"

namespace waystone {
namespace {

// The ids of each kind, by its value.
using IdsByKind = std::array<std::vector<int64_t>, 3>;

void CheckRange(const IdsByKind& ids, const std::string& where, const NamedRange& range,
                std::vector<MapProblem>& problems) {
  const std::string kind(NameOf(range.kind));
  if (range.first > range.last) {
    problems.push_back({where, kind + " from " + std::to_string(range.first) + " to " +
                                   std::to_string(range.last)});
  }
  for (const int64_t id : {range.first, range.last}) {
    if (std::ranges::binary_search(ids[static_cast<size_t>(range.kind)], id)) continue;
    problems.push_back({where, kind + " " + std::to_string(id) + ", which the map hasn't got"});
  }
}

}  // namespace

void FindNameProblems(const MapData& map, std::vector<MapProblem>& problems) {
  if (map.names.empty()) return;
  const IdsByKind ids{IdsOf(map, NamedKind::kKeyframes), IdsOf(map, NamedKind::kNodes),
                      IdsOf(map, NamedKind::kPlanes)};
  for (const NamedPlace& place : map.names) {
    const std::string where = "named place '" + Printable(place.name.substr(0, 80)) + "'";
    if (const auto problem = FindNameProblem(place.name)) {
      problems.push_back({where, "its name " + *problem});
    }
    for (const NamedRange& range : place.ranges) CheckRange(ids, where, range, problems);
    for (const NamedPolygon& polygon : place.polygons) {
      if (const auto problem = FindPolygonProblem(polygon)) {
        problems.push_back({where, "a polygon " + *problem});
      }
    }
    if (!place.polygons.empty() && !map.poses && !map.appearance) {
      problems.push_back({where, "has a polygon, and the map has no positions"});
    }
  }
  if (const auto problem = FindBoundProblem(map.names)) {
    problems.push_back({"named places", *problem});
  }
  if (Canonical(map.names) != map.names) {
    problems.push_back({"named places", "aren't in order, or repeat themselves"});
  }
}

}  // namespace waystone
