// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/planes/surfaces.h"

#include <boost/pending/disjoint_sets.hpp>
#include <set>
#include <unordered_map>

namespace waystone {

bool JoinsOneSurface(const Edge& edge) { return edge.homology == Eigen::Matrix3d::Identity(); }

std::vector<PlaneId> FindSurfaces(const std::vector<Plane>& planes,
                                  const std::vector<Edge>& edges) {
  std::unordered_map<PlaneId, size_t> row;
  for (const Plane& plane : planes) row.emplace(plane.id, row.size());
  boost::disjoint_sets_with_storage<> sets(planes.size());
  for (const Edge& edge : edges) {
    if (!JoinsOneSurface(edge)) continue;
    const auto a = row.find(edge.a);
    const auto b = row.find(edge.b);
    if (a != row.end() && b != row.end()) sets.union_set(a->second, b->second);
  }
  std::unordered_map<size_t, PlaneId> lowest;  // of each set
  for (const Plane& plane : planes) {
    const auto [at, is_new] = lowest.emplace(sets.find_set(row.at(plane.id)), plane.id);
    if (!is_new && plane.id < at->second) at->second = plane.id;
  }
  std::vector<PlaneId> surfaces;
  for (size_t p = 0; p < planes.size(); ++p) surfaces.push_back(lowest.at(sets.find_set(p)));
  return surfaces;
}

int CountSurfaces(const std::vector<PlaneId>& surface_of_plane) {
  return static_cast<int>(std::set(surface_of_plane.begin(), surface_of_plane.end()).size());
}

}  // namespace waystone
