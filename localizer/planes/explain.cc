// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/explain.h"

#include <algorithm>

namespace waystone {
namespace {

using Eigen::Vector2d;

const VerifiedPlane* Find(const std::vector<VerifiedPlane>& tried, int plane) {
  const auto it = std::find_if(tried.begin(), tried.end(),
                               [&](const VerifiedPlane& one) { return one.plane == plane; });
  return it == tried.end() ? nullptr : &*it;
}

void Fill(const Plane& plane, const Features& query, const VerifiedPlane& verified,
          ExplainedCandidate& candidate) {
  candidate.matches = verified.matches;
  candidate.distinct = verified.distinct;
  candidate.stopped_by = verified.stopped_by;
  for (const Match& match : verified.inliers) {
    candidate.query_points.push_back(PositionOf(query.keypoints[match.a]));
    candidate.reference_points.push_back(PositionOf(plane.features[match.b].reference));
  }
}

ExplainedPlace ExplainPlace(const MapIndex& index, const Features& query, const Place& place) {
  ExplainedPlace out;
  out.nearest = NearestKeyframe(index, place, query);
  for (const VerifiedPlane& member : place.planes) {
    out.planes.push_back(index.map().planes[member.plane].id);
  }
  out.inliers = CountInliers(place);
  out.best_share = place.evidence.best_share;
  out.probability = place.probability;
  return out;
}

ExplainedKeyframe ExplainKeyframe(const MapIndex& index, const VerifiedKeyframe& verified,
                                  const std::vector<Place>& places) {
  ExplainedKeyframe out;
  out.keyframe = index.map().keyframes[verified.keyframe].id;
  out.matches = verified.matches;
  out.inliers = verified.distinct;
  out.independent = verified.independent;
  out.expected = verified.expected;
  out.coverage = verified.coverage;
  out.query_points = verified.query_points;
  out.keyframe_points = verified.keyframe_points;
  for (size_t i = 0; i < places.size(); ++i) {
    const auto& keyframe = places[i].keyframe;
    if (keyframe && keyframe->keyframe == verified.keyframe) out.place = static_cast<int>(i);
  }
  return out;
}

int PlaceWith(const std::vector<ExplainedPlace>& places, PlaneId plane) {
  for (size_t i = 0; i < places.size(); ++i) {
    const std::vector<PlaneId>& planes = places[i].planes;
    if (std::find(planes.begin(), planes.end(), plane) != planes.end()) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

Explanation Explain(const MapIndex& index, const Features& query, const Shortlist& shortlist,
                    const std::vector<VerifiedPlane>& tried,
                    const std::vector<VerifiedKeyframe>& keyframes,
                    const std::vector<Place>& places, const PlaneQueryOptions& options) {
  Explanation explanation{query.width, query.height, query.size(), options.gates, {}, {}, {}};
  for (const Place& place : places) {
    explanation.places.push_back(ExplainPlace(index, query, place));
  }
  for (const VerifiedKeyframe& verified : keyframes) {
    explanation.keyframes.push_back(ExplainKeyframe(index, verified, places));
  }
  const VerifiedPlane* best = nullptr;  // of those accepted so far, as in TryPlanes
  for (const ShortlistedPlane& listed : shortlist.planes) {
    const Plane& plane = index.map().planes[listed.plane];
    ExplainedCandidate candidate;
    candidate.plane = plane.id;
    candidate.reference = plane.reference;
    candidate.votes = listed.votes;
    if (const VerifiedPlane* verified = Find(tried, listed.plane)) {
      Fill(plane, query, *verified, candidate);
      candidate.place = PlaceWith(explanation.places, plane.id);
      const bool better = !best || verified->distinct > best->distinct;
      if (verified->accepted && better) best = verified;
    } else {
      const bool beaten = best && IsBeaten(index, listed, *best, options);
      candidate.stopped_by = beaten ? Gate::kSettled : Gate::kNoHomography;
    }
    explanation.candidates.push_back(std::move(candidate));
  }
  return explanation;
}

}  // namespace waystone
