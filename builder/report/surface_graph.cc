// SPDX-License-Identifier: Apache-2.0
#include "builder/report/surface_graph.h"

#include <algorithm>
#include <map>
#include <set>

#include "schema/layers/planes/surfaces.h"

namespace waystone {

SurfaceGraph SurfacesOf(const MapData& map) {
  const std::vector<PlaneId> surface_of_plane = FindSurfaces(map.planes, map.edges);
  std::map<PlaneId, Surface> surfaces;
  SurfaceGraph graph;
  for (size_t p = 0; p < map.planes.size(); ++p) {
    const Plane& plane = map.planes[p];
    Surface& surface = surfaces[surface_of_plane[p]];
    surface.id = surface_of_plane[p];
    surface.planes.push_back(plane.id);
    surface.features += plane.features.size();
    graph.of_plane[plane.id] = surface.id;
  }
  std::unordered_map<PlaneId, size_t> row;
  for (auto& [id, surface] : surfaces) {
    row[id] = graph.surfaces.size();
    graph.surfaces.push_back(std::move(surface));
  }
  std::set<std::pair<size_t, size_t>> edges;
  for (const Edge& edge : map.edges) {
    const size_t a = row.at(graph.of_plane.at(edge.a));
    const size_t b = row.at(graph.of_plane.at(edge.b));
    if (a != b) edges.insert(std::minmax(a, b));
  }
  graph.edges.assign(edges.begin(), edges.end());
  return graph;
}

}  // namespace waystone
