// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/map_data.h"

namespace waystone {

// Whether an edge marks its planes as parts of one surface: its homology is the identity. Pure;
// thread-safe, as all functions here.
bool JoinsOneSurface(const Edge& edge);

// The surface that each plane is part of, in the order of `planes`. Planes of the map are parts of
// one physical surface, such as a wall, as their reference images show it; those joined by edges
// with the identity as homology (sec. II-B: one and the same plane) are on one surface. A surface
// is identified by the lowest id of its planes.
std::vector<PlaneId> FindSurfaces(const std::vector<Plane>& planes, const std::vector<Edge>& edges);

// How many there are.
int CountSurfaces(const std::vector<PlaneId>& surface_of_plane);

}  // namespace waystone
