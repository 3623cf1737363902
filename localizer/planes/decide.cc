// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/decide.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "localizer/planes/outline.h"
#include "localizer/planes/surroundings.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Plane& PlaneOf(const MapIndex& index, const VerifiedPlane& verified) {
  return index.map().planes[verified.plane];
}

// A plane joins a place when it disagrees with none of its planes and is near one of them.
bool Joins(const MapIndex& index, const Place& place, const VerifiedPlane& candidate,
           const PlaneQueryOptions& options) {
  bool near = false;
  for (const VerifiedPlane& member : place.planes) {
    const std::optional<bool> agree = PlanesAgree(index, member, candidate, options);
    if (agree.has_value() && !*agree) return false;
    near = near || agree.has_value() ||
           PlanesAreNear(index, PlaneOf(index, member), PlaneOf(index, candidate));
  }
  return near;
}

KeyframeRef RefTo(const MapIndex& index, KeyframeId id) {
  const Keyframe& keyframe = *index.FindKeyframe(id);
  return {id, index.FindSequence(keyframe.sequence)->name, keyframe.source, keyframe.time_s};
}

// v, rotated by the quarter turns by which the cameras' orientations at x differ: h is
// keyframe_from_query, and there = h x.
Vector2d TurnedAlike(const Vector2d& v, const Matrix3d& h, const Vector3d& there) {
  // The images of steps to the right and down at x, up to a factor.
  const Vector2d right = (there.z() * h.col(0) - h(2, 0) * there).head<2>();
  const Vector2d down = (there.z() * h.col(1) - h(2, 1) * there).head<2>();
  const double cosine = right.x() + down.y();
  const double sine = right.y() - down.x();
  if (std::abs(cosine) >= std::abs(sine)) return cosine >= 0 ? v : Vector2d(-v);
  return sine > 0 ? Vector2d(-v.y(), v.x()) : Vector2d(v.y(), -v.x());
}

// Weight of a plane's inliers for a keyframe: how many there are, discounted by how far they moved
// from the middle of the image, as a share of its longer side. Independent of the image's size and
// of a camera held on its side. It ranks a place's keyframes, not places.
double Closeness(const VerifiedPlane& plane, const Matrix3d& keyframe_from_query,
                 const Features& query, const Keyframe& keyframe) {
  constexpr double kMotionShare = 0.25;  // where the discount reaches 1/e
  const Vector2d query_middle = Vector2d(query.width, query.height) / 2;
  const Vector2d keyframe_middle = Vector2d(keyframe.width, keyframe.height) / 2;
  const double query_side = std::max(query.width, query.height);
  const double keyframe_side = std::max(keyframe.width, keyframe.height);
  double sum = 0;
  for (const Match& match : plane.inliers) {
    const Vector2d x = PositionOf(query.keypoints[match.a]);
    const Vector3d there = keyframe_from_query * x.homogeneous();
    const Vector2d was = TurnedAlike((x - query_middle) / query_side, keyframe_from_query, there);
    const Vector2d is = (there.hnormalized() - keyframe_middle) / keyframe_side;
    const double moved = (is - was).norm();
    if (std::isfinite(moved)) sum += std::exp(-moved / kMotionShare);
  }
  return sum;
}

RecognisedPlane Recognised(const MapIndex& index, const Features& query,
                           const VerifiedPlane& verified, const std::set<PlaneId>& present) {
  const Plane& plane = PlaneOf(index, verified);
  RecognisedPlane recognised;
  recognised.id = plane.id;
  recognised.inliers = static_cast<int>(verified.inliers.size());
  recognised.reference = RefTo(index, plane.reference);
  recognised.reference_from_query = verified.reference_from_query.b_from_a;
  for (const Match& match : verified.inliers) {
    recognised.query_points.push_back(PositionOf(query.keypoints[match.a]));
    recognised.reference_points.push_back(PositionOf(plane.features[match.b].reference));
  }
  recognised.outline =
      ClippedOutline(plane.outline, recognised.reference_from_query.inverse(),
                     recognised.reference_points.front(), query.width, query.height);
  for (PlaneId neighbour : index.Neighbours(plane.id)) {
    if (!present.contains(neighbour)) recognised.expect_next.push_back(neighbour);
  }
  return recognised;
}

// Whether a keyframe belongs to a visit, or follows or precedes it.
bool IsIn(const MapIndex& index, const Visit& visit, int keyframe) {
  return (visit.first <= keyframe && keyframe <= visit.last) ||
         FollowEachOther(index, visit.first, keyframe) ||
         FollowEachOther(index, visit.last, keyframe);
}

// Whether planes of both places are near each other.
bool HaveNearPlanes(const MapIndex& index, const Place& a, const Place& b) {
  return std::ranges::any_of(a.planes, [&](const VerifiedPlane& m) {
    return std::ranges::any_of(b.planes, [&](const VerifiedPlane& n) {
      return PlanesAreNear(index, PlaneOf(index, m), PlaneOf(index, n));
    });
  });
}

PlaceCandidate Candidate(const MapIndex& index, const Place& place, const Features& query) {
  return {RefTo(index, NearestKeyframe(index, place, query)), place.probability,
          CountInliers(place)};
}

// "plane 12 fits 8 of its 40 matches"
std::string PlaneText(const MapIndex& index, const VerifiedPlane& plane) {
  return "plane " + std::to_string(PlaneOf(index, plane).id.value) + " fits " +
         std::to_string(plane.distinct) + " of its " + std::to_string(plane.matches) + " matches";
}

// Reports the gate that stopped the best plane and what would have passed it.
void RefusePlane(const MapIndex& index, const VerifiedPlane& best, const GateOptions& gates,
                 Answer& answer) {
  const std::string plane = "the best " + PlaneText(index, best);
  switch (best.stopped_by) {
    case Gate::kMinInlierShare:
      answer.decided_by = DecidedBy::kInlierShare;
      answer.message = plane + ", which is less than the required " +
                       PercentText(gates.min_inlier_share) +
                       "; send a sharper image or one with fewer repeated patterns";
      return;
    case Gate::kMaxScale:
      answer.decided_by = DecidedBy::kHomographyScale;
      answer.message = plane + " at a scale that differs from the map's by more than a factor of " +
                       std::to_string(std::lround(gates.max_scale)) +
                       "; send an image from a distance closer to the map's";
      return;
    default:
      answer.decided_by = DecidedBy::kHomographyInliers;
      answer.message = plane + ", required are " + std::to_string(gates.min_inliers) +
                       "; show more of the place";
  }
}

// No place: names the gate that stopped the best plane.
Answer RefusePlanes(const MapIndex& index, const Features& query, int shortlisted,
                    const std::vector<VerifiedPlane>& tried, const PlaneQueryOptions& options) {
  Answer answer;
  if (query.size() < options.gates.min_inliers) {
    answer.decided_by = DecidedBy::kFeatures;
    answer.message = "the image has " + std::to_string(query.size()) +
                     " features, too few to match; send a sharper or more textured image";
    return answer;
  }
  if (tried.empty()) {
    answer.decided_by =
        shortlisted == 0 ? DecidedBy::kShortlistVotes : DecidedBy::kHomographyInliers;
    answer.message = shortlisted == 0 ? "no mapped plane has features similar to the image's"
                                      : "none of the " + std::to_string(shortlisted) +
                                            " candidate planes has a homography to the image";
    return answer;
  }
  const VerifiedPlane& best =
      *std::max_element(tried.begin(), tried.end(),
                        [](const auto& a, const auto& b) { return a.distinct < b.distinct; });
  Place place;
  AddTo(index, place, best);
  if (best.stopped_by == Gate::kMinInlierShare || best.stopped_by == Gate::kMaxScale) {
    place.probability = 0;  // not a place, however many inliers it has
  }
  answer.planes.runner_up = Candidate(index, place, query);
  answer.probability = place.probability;
  RefusePlane(index, best, options.gates, answer);
  return answer;
}

// "keyframe, 12.jpg, shares 30 matches", or the text of its best plane.
std::string PlaceText(const MapIndex& index, const Place& place, const PlaceCandidate& described) {
  if (!place.keyframe) return PlaneText(index, place.planes.front());
  return "keyframe, " + described.keyframe.source + ", shares " +
         std::to_string(CountInliers(place)) + " matches";
}

// A place that isn't probable enough.
Answer RefusePlace(const MapIndex& index, const Place& best, const PlaceCandidate& described,
                   const PlaneQueryOptions& options) {
  Answer answer;
  answer.planes.runner_up = described;
  answer.probability = best.probability;
  answer.decided_by = DecidedBy::kPlaceProbability;
  answer.message = "the best " + PlaceText(index, best, described) + ": probability " +
                   PercentText(best.probability) + ", required " +
                   PercentText(options.gates.min_probability) + "; show more of the place";
  return answer;
}

EpipolarMatches DescribeEpipolar(const MapIndex& index, const VerifiedKeyframe& verified) {
  return {RefTo(index, index.map().keyframes[verified.keyframe].id), verified.distinct,
          verified.matches, verified.query_points, verified.keyframe_points};
}

Answer Describe(const MapIndex& index, const Features& query, const Place& place,
                const PlaceCandidate& described) {
  Answer answer;
  answer.verdict = Verdict::kLocalized;
  answer.decided_by =
      place.planes.empty() ? DecidedBy::kEpipolarInliers : DecidedBy::kHomographyInliers;
  answer.probability = place.probability;
  if (place.keyframe) answer.planes.epipolar = DescribeEpipolar(index, *place.keyframe);
  answer.planes.keyframe = described.keyframe;
  std::set<PlaneId> present;
  for (const VerifiedPlane& plane : place.planes) present.insert(PlaneOf(index, plane).id);
  for (const VerifiedPlane& plane : place.planes) {
    answer.planes.recognised.push_back(Recognised(index, query, plane, present));
  }
  std::stable_sort(answer.planes.recognised.begin(), answer.planes.recognised.end(),
                   [](const auto& a, const auto& b) { return a.inliers > b.inliers; });
  return answer;
}

// Whether the query may be at a place instead of the best one. An epipolar geometry fits some
// matches of any two images, so a keyframe must be somewhat likely; planes by themselves don't
// count missing features, so their inliers decide.
bool MayBeInstead(const Place& place, const Place& best, const PlaneQueryOptions& options) {
  const GateOptions& gates = options.gates;
  if (place.keyframe && best.keyframe) return place.probability >= gates.min_rival_probability;
  return CountInliers(place) >= gates.ambiguous_share * CountInliers(best);
}

// The probability that the best place is right, given that the query is at no more than one of the
// places: its odds as a share of all odds and of none of them being right.
double ProbabilityBeside(const Place& best, const std::vector<const Place*>& rivals) {
  const auto odds = [](const Place& place) {
    return place.probability / std::max(1e-9, 1 - place.probability);
  };
  double all = 1 + odds(best);
  for (const Place* rival : rivals) all += odds(*rival);
  return odds(best) / all;
}

// Counts inliers of a plane that none of a place's planes has; where planes overlap, a feature of
// the query may be an inlier of both.
int CountNew(const Place& place, const VerifiedPlane& plane) {
  std::set<int> counted;
  for (const VerifiedPlane& member : place.planes) {
    for (const Match& match : member.inliers) counted.insert(match.a);
  }
  const auto fresh = std::ranges::count_if(
      plane.inliers, [&](const Match& match) { return !counted.contains(match.a); });
  return std::min(plane.distinct, static_cast<int>(fresh));
}

}  // namespace

void AddTo(const MapIndex& index, Place& place, const VerifiedPlane& plane) {
  place.evidence.inliers += CountNew(place, plane);
  if (place.planes.empty()) {
    place.evidence.best_share = static_cast<double>(plane.distinct) / std::max(1, plane.matches);
  }
  place.probability =
      EstimateProbability(place.evidence, index.map().verdict.value_or(VerdictModel{}));
  place.planes.push_back(plane);
}

int CountInliers(const Place& place) {
  return std::max(place.evidence.inliers, place.keyframe ? place.keyframe->distinct : 0);
}

std::vector<const Place*> FindRivals(const MapIndex& index, const std::vector<Place>& places,
                                     const PlaneQueryOptions& options) {
  std::vector<const Place*> rivals;
  std::optional<std::set<int>> near;  // the best place's keyframe
  for (size_t i = 1; i < places.size(); ++i) {
    const Place& place = places[i];
    if (!MayBeInstead(place, places[0], options)) continue;
    if (!places[0].keyframe || !place.keyframe) {
      if (!HaveNearPlanes(index, places[0], place)) rivals.push_back(&place);
      continue;
    }
    const int keyframe = place.keyframe->keyframe;
    if (WereTakenInARow(index, places[0].keyframe->keyframe, keyframe)) continue;
    if (!near) near = KeyframesNearThird(index, places[0].keyframe->keyframe);
    if (!near->contains(keyframe)) rivals.push_back(&place);
  }
  return rivals;
}

std::vector<Place> GroupPlaces(const MapIndex& index, std::vector<VerifiedPlane> accepted,
                               const PlaneQueryOptions& options) {
  std::stable_sort(accepted.begin(), accepted.end(),
                   [](const auto& a, const auto& b) { return a.distinct > b.distinct; });
  std::vector<Place> places;
  for (const VerifiedPlane& plane : accepted) {
    const auto home = std::find_if(places.begin(), places.end(), [&](const Place& place) {
      return Joins(index, place, plane, options);
    });
    Place& place = home == places.end() ? places.emplace_back() : *home;
    AddTo(index, place, plane);
  }
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.evidence.inliers > b.evidence.inliers;
  });
  return places;
}

std::vector<Place> FindPlaces(const MapIndex& index, const std::vector<VerifiedPlane>& tried,
                              const PlaneQueryOptions& options) {
  std::vector<VerifiedPlane> accepted;
  for (const VerifiedPlane& plane : tried) {
    if (plane.accepted) accepted.push_back(plane);
  }
  return GroupPlaces(index, std::move(accepted), options);
}

std::vector<Visit> FindVisits(const MapIndex& index, const Place& place, const Features& query) {
  std::map<int, double> closeness;  // of the keyframes that saw the place
  for (const VerifiedPlane& plane : place.planes) {
    const std::vector<PlaneView>& views = PlaneOf(index, plane).views;
    const std::vector<int>& saw = index.KeyframesThatSaw(plane.plane);
    for (size_t v = 0; v < views.size(); ++v) {
      closeness[saw[v]] += Closeness(
          plane, views[v].reference_from_keyframe.inverse() * plane.reference_from_query.b_from_a,
          query, index.map().keyframes[saw[v]]);
    }
  }
  std::vector<Visit> visits;
  for (const auto& [keyframe, close] : closeness) {
    if (visits.empty() || !FollowEachOther(index, visits.back().last, keyframe)) {
      visits.push_back({keyframe, keyframe, keyframe, close});
    }
    Visit& visit = visits.back();
    visit.last = keyframe;
    if (close > visit.closeness) {
      visit.nearest = keyframe;
      visit.closeness = close;
    }
  }
  std::ranges::stable_sort(visits, std::greater<>(), &Visit::closeness);
  return visits;
}

KeyframeId NearestKeyframe(const MapIndex& index, const Place& place, const Features& query) {
  const std::vector<Keyframe>& keyframes = index.map().keyframes;
  if (place.keyframe && place.keyframe->distinct > place.evidence.inliers) {
    return keyframes[place.keyframe->keyframe].id;
  }
  const std::vector<Visit> visits = FindVisits(index, place, query);
  if (!place.keyframe) return keyframes[visits.front().nearest].id;
  const int verified = place.keyframe->keyframe;
  const auto visit =
      std::ranges::find_if(visits, [&](const Visit& one) { return IsIn(index, one, verified); });
  return keyframes[visit == visits.end() ? verified : visit->nearest].id;
}

Answer Decide(const MapIndex& index, const Features& query, int shortlisted,
              const std::vector<VerifiedPlane>& tried, const std::vector<Place>& places,
              const PlaneQueryOptions& options) {
  if (places.empty()) return RefusePlanes(index, query, shortlisted, tried, options);
  std::vector<PlaceCandidate> candidates;
  for (const Place& place : places) candidates.push_back(Candidate(index, place, query));
  Answer answer = places[0].probability < options.gates.min_probability
                      ? RefusePlace(index, places[0], candidates[0], options)
                      : Describe(index, query, places[0], candidates[0]);
  answer.planes.candidates = candidates;
  if (answer.verdict != Verdict::kLocalized || places.size() < 2) return answer;
  const std::vector<const Place*> rivals = FindRivals(index, places, options);
  if (rivals.empty()) {
    answer.planes.runner_up = candidates[1];
    return answer;
  }
  answer.planes.runner_up = candidates[rivals.front() - places.data()];
  answer.probability = ProbabilityBeside(places[0], rivals);
  // Planes by themselves don't count missing features, and can't distinguish the place from a
  // rival.
  if (places[0].keyframe && answer.probability >= options.gates.min_probability) return answer;
  answer.verdict = Verdict::kAmbiguous;
  answer.decided_by = DecidedBy::kAmbiguousPlaces;
  answer.planes.keyframe.reset();
  answer.message = "several mapped places match; move a little and query again";
  answer.planes.places.push_back(candidates[0]);
  for (const Place* rival : rivals) {
    answer.planes.places.push_back(candidates[rival - places.data()]);
  }
  return answer;
}

}  // namespace waystone
