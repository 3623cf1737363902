// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/map_data.h"

namespace waystone {

// Whether two planes that were seen together lie on one surface, such as two posters on a wall, or
// a wall's part in one reference image and its part in the next: from each keyframe that saw both
// to every other such keyframe, the planes' homographies take the features of either to the same
// place, within `max_apart_px` (the median over a plane's features that both keyframes show, in
// their pixels). This is the homology test of sec. II-B (the identity: one and the same plane) over
// all pairs of keyframes instead of two consecutive ones, and the pair with the largest distance
// decides: parts of one wall stay together however far the camera moves. Of more than twenty
// keyframes, twenty spread over all are compared. False where no two keyframes show enough features
// of both. Pure; thread-safe.
bool LieOnOneSurface(const Plane& m, const Plane& n, const std::vector<Keyframe>& keyframes,
                     double max_apart_px);

// Gives the edges between such planes the identity as homology, which marks one surface
// (FindSurfaces). Edges that have it keep it. `planes` and `keyframes` are ordered by id.
// Deterministic on any number of threads (it uses TBB's); thread-safe for different edges.
void JoinSurfaces(const std::vector<Plane>& planes, const std::vector<Keyframe>& keyframes,
                  double max_apart_px, std::vector<Edge>& edges);

}  // namespace waystone
