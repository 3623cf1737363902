// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <unordered_map>
#include <utility>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// A surface of a map: the planes that are parts of it.
struct Surface {
  PlaneId id;  // the lowest of its planes
  std::vector<PlaneId> planes;
  size_t features = 0;  // of them all
};

// The graph of planes with the planes of one surface merged into one node.
struct SurfaceGraph {
  std::vector<Surface> surfaces;                  // by id
  std::vector<std::pair<size_t, size_t>> edges;   // rows of `surfaces`, each pair once, ascending
  std::unordered_map<PlaneId, PlaneId> of_plane;  // the surface of each plane
};
// Pure; thread-safe.
SurfaceGraph SurfacesOf(const MapData& map);

}  // namespace waystone
