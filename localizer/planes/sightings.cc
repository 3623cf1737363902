// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/sightings.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <utility>

#include "localizer/planes/spread.h"
#include "localizer/verdict/keyframe_verdict.h"

namespace waystone {
namespace {

// In a stretch, steps between keyframes that show one surrounding: each still shares
// min_matches_before_last features with the one two steps before, and so with a third view between
// them. Where a stretch ends nothing is shared by construction, but the camera has hardly moved.
constexpr int kNearKeyframes = 4;
constexpr int kNextKeyframes = 2;

double ShareOf(int part, int all) {
  return std::min(1.0, static_cast<double>(part) / std::max(1, all));
}

// Within one session.
bool ShowOneSurrounding(const MapIndex& index, int a, int b) {
  const Keyframe& x = index.map().keyframes[a];
  const Keyframe& y = index.map().keyframes[b];
  const int near = x.stretch == y.stretch ? kNearKeyframes : kNextKeyframes;
  if (x.sequence == y.sequence && std::abs(a - b) <= near) return true;
  return std::ranges::any_of(index.PlanesSeenBy(a), [&](const MapIndex::SeenPlane& in_a) {
    return std::ranges::any_of(index.PlanesSeenBy(b), [&](const MapIndex::SeenPlane& in_b) {
      return in_a.plane == in_b.plane;
    });
  });
}

// The linked keyframes that show one surrounding with `keyframe`, each once or more often.
std::vector<int> LinkedKeyframesAround(const MapIndex& index, int keyframe) {
  std::vector<int> around;
  const auto add = [&](int other) {
    if (!index.LinkedTo(other).empty()) around.push_back(other);
  };
  const int last = static_cast<int>(index.map().keyframes.size()) - 1;
  for (int other = std::max(0, keyframe - kNearKeyframes);
       other <= std::min(last, keyframe + kNearKeyframes); ++other) {
    if (ShowOneSurrounding(index, keyframe, other)) add(other);
  }
  for (const MapIndex::SeenPlane& seen : index.PlanesSeenBy(keyframe)) {
    for (const PlaneView& view : index.map().planes[seen.plane].views) {
      add(index.IndexOf(view.keyframe));
    }
  }
  return around;
}

// Planes recognise a surface from farther aside than a keyframe is, so that their inliers count as
// found too.
KeyframeEvidence EvidenceFor(const VerifiedKeyframe& verified, const Place& place,
                             const Features& query, const GateOptions& gates) {
  std::vector<Eigen::Vector2d> found = verified.query_points;
  for (const VerifiedPlane& plane : place.planes) {
    for (const Match& match : plane.inliers) found.push_back(PositionOf(query.keypoints[match.a]));
  }
  KeyframeEvidence evidence;
  evidence.significance = verified.significance;
  evidence.found_share = ShareOf(CountApart(found, gates.distinct_px), verified.expected);
  evidence.coverage = ComputeCoverage(found, query.width, query.height);
  evidence.inlier_share = ShareOf(verified.distinct, verified.matches);
  evidence.planes = static_cast<int>(place.planes.size());
  return evidence;
}

// Whether a keyframe saw a plane of the place, or one near it.
bool Shows(const MapIndex& index, int keyframe, const Place& place) {
  if (place.keyframe && KeyframesAreNear(index, place.keyframe->keyframe, keyframe)) return true;
  const std::vector<Plane>& planes = index.map().planes;
  const std::vector<MapIndex::SeenPlane>& seen = index.PlanesSeenBy(keyframe);
  return std::ranges::any_of(place.planes, [&](const VerifiedPlane& member) {
    return std::ranges::any_of(seen, [&](const MapIndex::SeenPlane& one) {
      return PlanesAreNear(index, planes[member.plane], planes[one.plane]);
    });
  });
}

}  // namespace

std::vector<VerifiedKeyframe> VerifyKeyframes(const MapIndex& index, const Features& query,
                                              const Shortlist& shortlist,
                                              const std::vector<Place>& places,
                                              const PlaneQueryOptions& options,
                                              const Deadline& deadline) {
  if (!index.HasLandmarks()) return {};
  std::vector<VerifiedKeyframe> verified;
  std::vector<int> asked;
  const auto verify = [&](int keyframe) {
    if (HasPassed(deadline) || std::ranges::find(asked, keyframe) != asked.end()) return;
    asked.push_back(keyframe);
    if (auto one = VerifyKeyframe(index, query, keyframe, options)) {
      verified.push_back(std::move(*one));
    }
  };
  const auto sort = [&] {
    std::ranges::stable_sort(verified, std::greater<>(), &VerifiedKeyframe::distinct);
  };
  std::vector<Place> ranked = places;
  JoinKeyframes(index, query, {}, options, ranked);  // in the same order as with keyframes
  for (const Place& place : ranked) {
    if (std::ssize(asked) == options.max_keyframes) break;
    if (CountInliers(place) < options.gates.ambiguous_share * CountInliers(ranked.front())) break;
    verify(index.IndexOf(NearestKeyframe(index, place, query)));
  }
  sort();
  std::vector<Place> joined = places;
  JoinKeyframes(index, query, verified, options, joined);
  if (joined.empty() || joined.front().probability < options.gates.min_probability) {
    for (const ShortlistedKeyframe& candidate : shortlist.keyframes) verify(candidate.keyframe);
    sort();
  }
  return verified;
}

bool KeyframesAreNear(const MapIndex& index, int a, int b) {
  if (ShowOneSurrounding(index, a, b)) return true;
  if (index.map().links.empty()) return false;
  return std::ranges::any_of(LinkedKeyframesAround(index, a), [&](int linked) {
    return std::ranges::any_of(index.LinkedTo(linked),
                               [&](int other) { return ShowOneSurrounding(index, other, b); });
  });
}

void JoinKeyframes(const MapIndex& index, const Features& query,
                   const std::vector<VerifiedKeyframe>& keyframes, const PlaneQueryOptions& options,
                   std::vector<Place>& places) {
  for (const VerifiedKeyframe& verified : keyframes) {
    const auto home = std::ranges::find_if(
        places, [&](const Place& place) { return Shows(index, verified.keyframe, place); });
    if (home != places.end() && home->keyframe) continue;  // a better one is there
    if (home == places.end() && verified.distinct < options.gates.min_inliers) continue;
    Place& place = home == places.end() ? places.emplace_back() : *home;
    place.keyframe = verified;
    place.keyframe_evidence = EvidenceFor(verified, place, query, options.gates);
    place.probability = ComputeProbability(place.keyframe_evidence);
  }
  const auto rank = [&](const Place& place) {
    return std::pair(place.probability >= options.gates.min_probability, CountInliers(place));
  };
  std::ranges::stable_sort(places, std::greater<>(), rank);
}

}  // namespace waystone
