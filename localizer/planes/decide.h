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

// One place: planes that were recognised together and agree, or the keyframe that fits the query
// best, or both. All functions here are deterministic; thread-safe.
struct Place {
  std::vector<VerifiedPlane> planes;  // most inliers first
  Evidence evidence;                  // of the planes
  std::optional<VerifiedKeyframe> keyframe;
  KeyframeEvidence keyframe_evidence;  // of the keyframe, where there is one
  double probability = 0;              // that it is right
};

// The larger number of inliers, of the planes or of the epipolar geometry, at distinct positions of
// the query.
int CountInliers(const Place& place);

// Adds a plane that agrees with the place's planes and has at most as many inliers as each of them.
void AddTo(const MapIndex& index, Place& place, const VerifiedPlane& plane);

// Groups accepted planes into places, best first. Planes of one place were seen together and agree
// through their homology, or are neighbours in the graph.
std::vector<Place> GroupPlaces(const MapIndex& index, std::vector<VerifiedPlane> accepted,
                               const PlaneQueryOptions& options);

// The places of the accepted planes among those that were tried.
std::vector<Place> FindPlaces(const MapIndex& index, const std::vector<VerifiedPlane>& tried,
                              const PlaneQueryOptions& options);

// The places, not near the first (best) one, at which the query may be instead: somewhat likely
// ones, or, where either has no keyframe, those with enough inliers. Two places are near if a
// keyframe is near the verified keyframes of both (KeyframesNearThird), or if these were taken in a
// row (WereTakenInARow), or, where a place has none, if planes of both are near.
std::vector<const Place*> FindRivals(const MapIndex& index, const std::vector<Place>& places,
                                     const PlaneQueryOptions& options);

// Keyframes that follow each other (FollowEachOther) and saw planes of a place. Indices in the
// map's keyframes.
struct Visit {
  int first = 0;
  int last = 0;
  int nearest = 0;       // the one whose view of the place is most like the query's
  double closeness = 0;  // of the nearest: larger the more inliers lie near where it saw them
};

// The visits of a place's planes, nearest first.
std::vector<Visit> FindVisits(const MapIndex& index, const Place& place, const Features& query);

// The keyframe whose view of a place is most like the query's: of the visit of the place's verified
// keyframe, or that one itself where it has more inliers than the planes or is in no visit.
KeyframeId NearestKeyframe(const MapIndex& index, const Place& place, const Features& query);

// The verdict for all planes that were tried, accepted or not, of `shortlisted` ones, and for the
// places that they and the verified keyframes make (FindPlaces, JoinKeyframes), with everything an
// answer says about places. With rivals (FindRivals), an answer's probability is that of the best
// place given that the query is at no more than one of them; the answer is ambiguous where that is
// too low, or where the best place has no keyframe. Times, names and map are the caller's.
Answer Decide(const MapIndex& index, const Features& query, int shortlisted,
              const std::vector<VerifiedPlane>& tried, const std::vector<Place>& places,
              const PlaneQueryOptions& options);

}  // namespace waystone
