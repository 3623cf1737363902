// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/map_data.h"

namespace waystone {

// Whether two planes that were seen together lie on one surface, such as two posters on a wall, or
// a wall's part in one reference image and its part in the next: from each keyframe that saw both
// to each other one, the planes' homographies take the features of either to the same place, within
// `max_apart_px` (the median over a plane's features that both keyframes show, in their pixels).
// This is the homology test of sec. II-B (the identity: one and the same plane) over all pairs of
// keyframes instead of two consecutive ones, of which the widest decides: parts of one wall stay
// together however far the camera moves. Of more than twenty keyframes, twenty are compared that
// are spread over all. False where no two keyframes show enough features of both.
bool LieOnOneSurface(const Plane& m, const Plane& n, const std::vector<Keyframe>& keyframes,
                     double max_apart_px);

// Gives the edges between such planes the identity as homology, the sign of one surface
// (FindSurfaces). Edges that have it keep it. `planes` and `keyframes` are ordered by id.
void JoinSurfaces(const std::vector<Plane>& planes, const std::vector<Keyframe>& keyframes,
                  double max_apart_px, std::vector<Edge>& edges);

}  // namespace waystone
