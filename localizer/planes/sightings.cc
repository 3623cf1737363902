// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/sightings.h"

#include <algorithm>
#include <functional>
#include <set>
#include <utility>

#include "localizer/planes/spread.h"
#include "localizer/planes/surroundings.h"
#include "localizer/verdict/keyframe_verdict.h"

namespace waystone {
namespace {

// 0 where `all` is 0.
double ShareOf(int part, int all) {
  return all == 0 ? 0 : std::min(1.0, static_cast<double>(part) / all);
}

// Planes recognise a surface from viewpoints farther away than a keyframe does, so their inliers
// count as found too.
KeyframeEvidence EvidenceFor(const VerifiedKeyframe& verified, const Place& place,
                             const Features& query, const GateOptions& gates) {
  std::vector<Eigen::Vector2d> found = verified.query_points;
  for (const VerifiedPlane& plane : place.planes) {
    for (const Match& match : plane.inliers) found.push_back(PositionOf(query.keypoints[match.a]));
  }
  KeyframeEvidence evidence;
  evidence.significance = verified.significance;
  evidence.independent_significance = verified.independent_significance;
  evidence.coverage = ComputeCoverage(found, query.width, query.height);
  std::erase_if(found, [&](const auto& x) { return !CanShow(query, x); });  // none is expected
  evidence.found_share = ShareOf(CountApart(found, gates.distinct_px), verified.expected);
  evidence.inlier_share = ShareOf(verified.distinct, verified.matches);
  return evidence;
}

// Whether a keyframe saw a plane of a place, or one near it.
bool SawPlanesOf(const MapIndex& index, int keyframe, const Place& place) {
  const std::vector<Plane>& planes = index.map().planes;
  const std::vector<MapIndex::SeenPlane>& seen = index.PlanesSeenBy(keyframe);
  return std::ranges::any_of(place.planes, [&](const VerifiedPlane& member) {
    return std::ranges::any_of(seen, [&](const MapIndex::SeenPlane& one) {
      return PlanesAreNear(index, planes[member.plane], planes[one.plane]);
    });
  });
}

// A place while keyframes are joined to places.
struct JoinedPlace {
  Place place;
  int group = -1;      // of planes: which of the places that were given; -1 for none
  std::set<int> near;  // keyframes near the place's own
};

bool WasSeenFrom(const MapIndex& index, const VerifiedPlane& plane, const std::set<int>& near) {
  return std::ranges::any_of(index.KeyframesThatSaw(plane.plane),
                             [&](int keyframe) { return near.contains(keyframe); });
}

// A place without a keyframe is at most as probable as those whose keyframes saw its planes: when a
// keyframe refuses them, a part that contradicts the rest isn't an answer.
void BoundByKeyframes(const MapIndex& index, std::vector<Place>& places) {
  for (Place& place : places) {
    if (place.keyframe) continue;
    for (const Place& other : places) {
      if (!other.keyframe || !SawPlanesOf(index, other.keyframe->keyframe, place)) continue;
      place.probability = std::min(place.probability, other.probability);
    }
  }
}

// Assigns to each visit of a group's planes those seen from near it; the first one also gets those
// seen from near none.
void DividePlanes(const MapIndex& index, const std::vector<VerifiedPlane>& planes,
                  const std::vector<JoinedPlace*>& visits) {
  for (JoinedPlace* visit : visits) {
    visit->place.planes.clear();
    visit->place.evidence = {};
  }
  for (const VerifiedPlane& plane : planes) {
    bool was_seen = false;
    for (JoinedPlace* visit : visits) {
      if (!WasSeenFrom(index, plane, visit->near)) continue;
      was_seen = true;
      AddTo(index, visit->place, plane);
    }
    if (!was_seen) AddTo(index, visits.front()->place, plane);
  }
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
    verified.push_back(VerifyKeyframe(index, query, keyframe, options));
  };
  const auto sort = [&] {
    std::ranges::stable_sort(verified, std::greater<>(), &VerifiedKeyframe::distinct);
  };
  const auto join = [&] {
    sort();
    std::vector<Place> joined = places;
    JoinKeyframes(index, query, verified, options, joined);
    return joined;
  };
  const std::vector<Place> ranked = join();  // without keyframes, in the same order as with them
  for (const Place& place : ranked) {
    if (std::ssize(asked) == options.max_keyframes) break;
    if (CountInliers(place) < options.gates.ambiguous_share * CountInliers(ranked.front())) break;
    verify(index.IndexOf(NearestKeyframe(index, place, query)));
  }
  if (const std::vector<Place> joined = join(); !joined.empty()) {
    std::set<int> near;
    for (const int keyframe : asked) near.merge(KeyframesNear(index, keyframe));
    int visits = 0;
    for (const Visit& visit : FindVisits(index, joined.front(), query)) {
      if (near.contains(visit.nearest)) continue;
      if (++visits > options.max_keyframes) break;
      verify(visit.nearest);
      near.merge(KeyframesNear(index, visit.nearest));
    }
  }
  const auto is_settled = [&](const std::vector<Place>& joined) {
    return !joined.empty() && joined.front().probability >= options.gates.min_probability;
  };
  std::vector<Place> joined = join();
  if (!is_settled(joined)) {
    for (const ShortlistedKeyframe& candidate : shortlist.keyframes) verify(candidate.keyframe);
    joined = join();
  }
  // The place that now comes first may not have had a keyframe verified.
  while (is_settled(joined) && !joined.front().keyframe) {
    const size_t before = asked.size();
    verify(index.IndexOf(NearestKeyframe(index, joined.front(), query)));
    if (asked.size() == before) break;
    joined = join();
  }
  return verified;
}

void JoinKeyframes(const MapIndex& index, const Features& query,
                   const std::vector<VerifiedKeyframe>& keyframes, const PlaneQueryOptions& options,
                   std::vector<Place>& places) {
  const std::vector<Place> groups = std::exchange(places, {});
  const int group_count = static_cast<int>(groups.size());
  std::vector<JoinedPlace> joined;
  for (int g = 0; g < group_count; ++g) joined.push_back({groups[g], g, {}});
  for (const VerifiedKeyframe& verified : keyframes) {
    const auto home = std::ranges::find_if(joined, [&](const JoinedPlace& one) {
      return one.place.keyframe ? one.near.contains(verified.keyframe)
                                : SawPlanesOf(index, verified.keyframe, one.place);
    });
    if (home != joined.end() && home->place.keyframe) continue;  // it already has a better one
    if (home == joined.end() && verified.distinct < options.gates.min_inliers) continue;
    JoinedPlace& one = home == joined.end() ? joined.emplace_back() : *home;
    one.place.keyframe = verified;
    one.near = KeyframesNear(index, verified.keyframe);
    for (int g = 0; g < group_count && one.group < 0; ++g) {
      if (SawPlanesOf(index, verified.keyframe, groups[g])) one.group = g;
    }
  }
  for (int g = 0; g < group_count; ++g) {
    std::vector<JoinedPlace*> visits;
    for (JoinedPlace& one : joined) {
      if (one.group == g) visits.push_back(&one);
    }
    if (visits.size() > 1) DividePlanes(index, groups[g].planes, visits);
  }
  for (JoinedPlace& one : joined) {
    Place& place = places.emplace_back(std::move(one.place));
    if (!place.keyframe) continue;
    place.keyframe_evidence = EvidenceFor(*place.keyframe, place, query, options.gates);
    place.probability = ComputeProbability(place.keyframe_evidence);
  }
  BoundByKeyframes(index, places);
  const auto rank = [&](const Place& place) {
    return std::pair(place.probability >= options.gates.min_probability, CountInliers(place));
  };
  std::ranges::stable_sort(places, std::greater<>(), rank);
}

}  // namespace waystone
