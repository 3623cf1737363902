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

// Adds a plane that agrees with the place's planes and has at most as many inliers as each of them.
void AddTo(const MapIndex& index, Place& place, const VerifiedPlane& plane);

// Groups accepted planes into places, best first. Planes of one place were seen together and agree
// through their homology, or are neighbours in the graph.
std::vector<Place> GroupPlaces(const MapIndex& index, std::vector<VerifiedPlane> accepted,
                               const PlaneQueryOptions& options);

// The places of all planes that were accepted of those that were tried.
std::vector<Place> FindPlaces(const MapIndex& index, const std::vector<VerifiedPlane>& tried,
                              const PlaneQueryOptions& options);

// The places where the query may be instead of the first one, the best, and which aren't near it:
// somewhat likely ones, or where either has no keyframe, those with enough inliers. Two are near
// if a keyframe is near the verified keyframes of both (KeyframesNearThird), or if these were taken
// in a row (WereTakenInARow), or where a place has none, if planes of both are near.
std::vector<const Place*> FindRivals(const MapIndex& index, const std::vector<Place>& places,
                                     const PlaneQueryOptions& options);

// Keyframes that follow each other (FollowEachOther) and saw planes of a place. Indices in the
// map's keyframes.
struct Visit {
  int first = 0;
  int last = 0;
  int nearest = 0;       // the one that saw the place most like the query did
  double closeness = 0;  // of the nearest: the more inliers lie near where it saw them, the more
};

// The visits of a place's planes, nearest first.
std::vector<Visit> FindVisits(const MapIndex& index, const Place& place, const Features& query);

// The keyframe that saw a place most like the query did: of the visit of the place's verified
// keyframe, or that one itself where it has more inliers than the planes or is in no visit.
KeyframeId NearestKeyframe(const MapIndex& index, const Place& place, const Features& query);

// The verdict for all planes that were tried, accepted or not, of `shortlisted` ones, and for the
// places that they and the verified keyframes make (FindPlaces, JoinKeyframes), with everything an
// answer says about places. Beside rivals (FindRivals), an answer's probability is that of the best
// place knowing that the query is at one of them at most; the answer is ambiguous where that is too
// little, or where the best place has no keyframe. Times, names and map are the caller's.
Answer Decide(const MapIndex& index, const Features& query, int shortlisted,
              const std::vector<VerifiedPlane>& tried, const std::vector<Place>& places,
              const PlaneQueryOptions& options);

}  // namespace waystone
