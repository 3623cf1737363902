// SPDX-License-Identifier: Apache-2.0
#include "api/explanation_json.h"

namespace waystone {
namespace {

Json PointsJson(const std::vector<Eigen::Vector2d>& query_points,
                const std::vector<Eigen::Vector2d>& other_points) {
  Json list = Json::array();
  for (size_t i = 0; i < query_points.size(); ++i) {
    const Eigen::Vector2d& q = query_points[i];
    const Eigen::Vector2d& r = other_points[i];
    list.push_back({Rounded(q.x(), 1), Rounded(q.y(), 1), Rounded(r.x(), 1), Rounded(r.y(), 1)});
  }
  return list;
}

Json CandidateJson(const ExplainedCandidate& candidate) {
  const bool passed = candidate.stopped_by == Gate::kPassed;
  Json json;
  json["plane"] = candidate.plane.value;
  json["reference"] = candidate.reference.value;
  json["votes"] = candidate.votes;
  json["matches"] = candidate.matches;
  json["inliers"] = candidate.distinct;
  json["stopped_by"] = passed ? Json(nullptr) : Json(NameOf(candidate.stopped_by));
  json["place"] = candidate.place < 0 ? Json(nullptr) : Json(candidate.place);
  json["points"] = PointsJson(candidate.query_points, candidate.reference_points);
  return json;
}

Json GatesJson(const GateOptions& gates) {
  return {{"min_inliers", gates.min_inliers},
          {"min_inlier_share", gates.min_inlier_share},
          {"max_scale", gates.max_scale},
          {"min_probability", gates.min_probability},
          {"ambiguous_share", gates.ambiguous_share}};
}

Json KeyframeJson(const ExplainedKeyframe& keyframe) {
  Json json;
  json["keyframe"] = keyframe.keyframe.value;
  json["matches"] = keyframe.matches;
  json["inliers"] = keyframe.inliers;
  json["independent"] = keyframe.independent;
  json["expected"] = keyframe.expected;
  json["coverage"] = Rounded(keyframe.coverage, 4);
  json["place"] = keyframe.place < 0 ? Json(nullptr) : Json(keyframe.place);
  json["points"] = PointsJson(keyframe.query_points, keyframe.keyframe_points);
  return json;
}

Json PlaceJson(const ExplainedPlace& place) {
  Json json;
  json["keyframe"] = place.nearest.value;
  json["planes"] = ToJson(place.planes);
  json["inliers"] = place.inliers;
  json["best_share"] = Rounded(place.best_share, 4);
  json["probability"] = Rounded(place.probability, 4);
  return json;
}

}  // namespace

Json ToJson(const Explanation& explanation) {
  Json json;
  json["image"] = {{"width", explanation.width},
                   {"height", explanation.height},
                   {"features", explanation.features}};
  json["gates"] = GatesJson(explanation.gates);
  json["candidates"] = Json::array();
  for (const ExplainedCandidate& candidate : explanation.candidates) {
    json["candidates"].push_back(CandidateJson(candidate));
  }
  json["keyframes"] = Json::array();
  for (const ExplainedKeyframe& keyframe : explanation.keyframes) {
    json["keyframes"].push_back(KeyframeJson(keyframe));
  }
  json["places"] = Json::array();
  for (const ExplainedPlace& place : explanation.places) json["places"].push_back(PlaceJson(place));
  return json;
}

}  // namespace waystone
