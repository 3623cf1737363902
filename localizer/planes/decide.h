// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localizer/planes/verify.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/verdict_model.h"

namespace waystone {

// Planes that were recognised together and agree: one place.
struct Place {
  std::vector<VerifiedPlane> planes;  // most inliers first
  Evidence evidence;
  double probability = 0;  // that it is right, by the map's model
};

// Whether two planes are parts of one surrounding: a keyframe saw both, or an edge or a common
// neighbour joins them.
bool PlanesAreNear(const MapIndex& index, const Plane& a, const Plane& b);

// Groups accepted planes into places, best first. Planes of one place were seen together and agree
// through their homology, or are neighbours in the graph.
std::vector<Place> GroupPlaces(const MapIndex& index, std::vector<VerifiedPlane> accepted,
                               const PlaneQueryOptions& options);

// The same for two places: whether planes of both are near each other.
bool AreNear(const MapIndex& index, const Place& a, const Place& b);

// The keyframe that saw a place most like the query did: the more of the place's inliers lie near
// where the keyframe saw them, the nearer.
KeyframeId NearestKeyframe(const MapIndex& index, const Place& place, const Features& query);

// The verdict for all planes that were tried, accepted or not, of `shortlisted` ones, with
// everything an answer says about places. Times, names and map are the caller's.
Answer Decide(const MapIndex& index, const Features& query, int shortlisted,
              const std::vector<VerifiedPlane>& tried, const PlaneQueryOptions& options);

}  // namespace waystone
