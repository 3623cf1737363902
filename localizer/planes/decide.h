// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "localizer/planes/verify.h"
#include "localizer/planes/verify_keyframe.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/keyframe_verdict.h"
#include "localizer/verdict/verdict_model.h"

namespace waystone {

// Planes that were recognised together and agree, and the keyframe that fits the query best: one
// place. It has either or both.
struct Place {
  std::vector<VerifiedPlane> planes;  // most inliers first
  Evidence evidence;                  // of the planes
  std::optional<VerifiedKeyframe> keyframe;
  KeyframeEvidence keyframe_evidence;  // of the keyframe, where there is one
  double probability = 0;              // that it is right
};

// Inliers of the planes or of the epipolar geometry, whichever are more, at distinct positions of
// the query.
int CountInliers(const Place& place);

// Whether two planes are parts of one surrounding: a keyframe saw both, or a link joins keyframes
// that saw them, or an edge or a common neighbour joins the planes.
bool PlanesAreNear(const MapIndex& index, const Plane& a, const Plane& b);

// Groups accepted planes into places, best first. Planes of one place were seen together and agree
// through their homology, or are neighbours in the graph.
std::vector<Place> GroupPlaces(const MapIndex& index, std::vector<VerifiedPlane> accepted,
                               const PlaneQueryOptions& options);

// The places of all planes that were accepted of those that were tried.
std::vector<Place> FindPlaces(const MapIndex& index, const std::vector<VerifiedPlane>& tried,
                              const PlaneQueryOptions& options);

// The same for two places: whether planes or keyframes of both are near each other.
bool AreNear(const MapIndex& index, const Place& a, const Place& b);

// The keyframe that saw a place most like the query did: the more of the place's inliers lie near
// where the keyframe saw them, the nearer. The place's verified keyframe where that has more
// inliers than the planes.
KeyframeId NearestKeyframe(const MapIndex& index, const Place& place, const Features& query);

// The verdict for all planes that were tried, accepted or not, of `shortlisted` ones, and for the
// places that they and the verified keyframes make (FindPlaces, JoinKeyframes), with everything an
// answer says about places. Times, names and map are the caller's.
Answer Decide(const MapIndex& index, const Features& query, int shortlisted,
              const std::vector<VerifiedPlane>& tried, const std::vector<Place>& places,
              const PlaneQueryOptions& options);

}  // namespace waystone
