// SPDX-License-Identifier: Apache-2.0
#include "api/answer_json.h"

#include <vector>

#include "api/explanation_json.h"

namespace waystone {
namespace {

Json KeyframeJson(const KeyframeRef& ref) {
  Json json;
  json["id"] = ref.id.value;
  json["sequence"] = ref.sequence;
  json["source"] = ref.source;
  json["time_s"] = OrNull(ref.time_s);
  return json;
}

Json HeadingJson(const Heading& heading) {
  Json json;
  json["rad"] = heading.rad;
  json["deviation_rad"] = heading.sigma_rad;
  json["of"] = NameOf(heading.frame);
  return json;
}

Json BuildingJson(const BuildingView& view) {
  Json json;
  json["heading"] = view.heading ? HeadingJson(*view.heading) : Json(nullptr);
  json["building_from_query"] =
      view.heading ? ToJson(view.building_from_query.toRotationMatrix()) : Json(nullptr);
  json["lines"] = view.lines;
  json["disagreement_rad"] = OrNull(view.disagreement_rad);
  return json;
}

Json PoseJson(const QueryPose& pose) {
  const Eigen::Quaterniond q(pose.frame_from_camera.linear());
  const Eigen::Vector3d& at = pose.frame_from_camera.translation();
  Json json;
  json["frame"] = pose.frame;
  json["unit"] = NameOf(pose.unit);
  json["position"] = {at.x(), at.y(), at.z()};
  json["orientation"] = {q.x(), q.y(), q.z(), q.w()};
  json["covariance"] = Json::array();
  for (int row = 0; row < pose.covariance.rows(); ++row) {
    const Eigen::RowVectorXd values = pose.covariance.row(row);
    json["covariance"].push_back(std::vector<double>(values.begin(), values.end()));
  }
  json["inliers"] = pose.inliers;
  json["camera"] = pose.by_own_camera ? "map" : "query";
  return json;
}

// Only for maps with poses.
void AddPose(const Answer& answer, Json& json) {
  if (!answer.pose && answer.pose_reason.empty()) return;
  json["pose"] = answer.pose ? PoseJson(*answer.pose) : Json(nullptr);
  if (!answer.pose) json["pose_reason"] = answer.pose_reason;
}

Json PlaneJson(const RecognisedPlane& plane) {
  Json json;
  json["id"] = plane.id.value;
  json["inliers"] = plane.inliers;
  json["reference"]["id"] = plane.reference.id.value;
  json["reference"]["source"] = plane.reference.source;
  json["reference_from_query"] = ToJson(plane.reference_from_query);
  json["outline"] = ToJson(plane.outline);
  json["expect_next"] = ToJson(plane.expect_next);
  return json;
}

Json EpipolarJson(const EpipolarMatches& epipolar) {
  Json json;
  json["keyframe"]["id"] = epipolar.keyframe.id.value;
  json["keyframe"]["source"] = epipolar.keyframe.source;
  json["inliers"] = epipolar.inliers;
  json["matches"] = epipolar.matches;
  return json;
}

Json RunnerUpJson(const PlaceCandidate& place) {
  Json json;
  json["keyframe"]["id"] = place.keyframe.id.value;
  json["probability"] = Rounded(place.probability, 4);
  return json;
}

Json NodeJson(const NodeRef& ref) {
  Json json;
  json["id"] = ref.id.value;
  json["sequence"] = ref.sequence;
  json["source"] = ref.source;
  json["time_s"] = OrNull(ref.time_s);
  return json;
}

Json CandidateJson(const NodeCandidate& candidate) {
  Json json;
  json["node"] = NodeJson(candidate.node);
  json["probability"] = Rounded(candidate.probability, 4);
  json["cost"] = Rounded(candidate.cost, 4);
  json["inliers"] = candidate.inliers;
  return json;
}

Json PositionJson(const PlacePosition& position) {
  Json json;
  json["x"] = Rounded(position.x, 4);
  json["y"] = Rounded(position.y, 4);
  json["deviation"] = Rounded(position.sigma, 4);
  json["metres_per_unit"] = OrNull(position.metres_per_unit);
  return json;
}

Json PlanJson(const PlanPosition& plan) {
  return {{"name", plan.name}, {"x", Rounded(plan.px.x(), 2)}, {"y", Rounded(plan.px.y(), 2)}};
}

// Unless localized, there are candidates but no place.
Json PanoramaJson(const PanoramaAnswer& panorama, const std::optional<AnsweredPlace>& place) {
  Json json;
  json["node"] = place ? NodeJson(panorama.node) : Json(nullptr);
  json["position"] = place ? PositionJson(*place->position) : Json(nullptr);
  json["candidates"] = Json::array();
  for (const NodeCandidate& node : panorama.candidates) {
    json["candidates"].push_back(CandidateJson(node));
  }
  json["runner_up"] = panorama.runner_up ? CandidateJson(*panorama.runner_up) : Json(nullptr);
  return json;
}

Json TimingJson(const StageTimes& times) {
  Json json;
  json["decode"] = Rounded(times.decode_ms, 2);
  json["extract"] = Rounded(times.extract_ms, 2);
  json["shortlist"] = Rounded(times.shortlist_ms, 2);
  json["verify"] = Rounded(times.verify_ms, 2);
  if (times.pose_ms > 0) json["pose"] = Rounded(times.pose_ms, 2);
  json["total"] = Rounded(times.total_ms, 2);
  return json;
}

}  // namespace

Json ToJson(const PlaceCandidate& place) {
  Json json;
  json["keyframe"] = KeyframeJson(place.keyframe);
  json["probability"] = Rounded(place.probability, 4);
  json["inliers"] = place.inliers;
  return json;
}

Json ToJson(const AnsweredPlace& place) {
  Json json;
  json["layer"] = NameOf(place.layer);
  json["id"] = place.id;
  json["name"] = OrNull(place.name);
  json["image"] = place.image;
  json["sequence"] = place.sequence;
  json["time_s"] = OrNull(place.time_s);
  json["position"] = place.position ? PositionJson(*place.position) : Json(nullptr);
  json["heading"] = place.heading ? HeadingJson(*place.heading) : Json(nullptr);
  json["plan"] = place.plan ? PlanJson(*place.plan) : Json(nullptr);
  return json;
}

Json ToJson(const Answer& answer) {
  const std::optional<AnsweredPlace> place = PlaceOf(answer);
  Json json;
  json["verdict"] = NameOf(answer.verdict);
  json["probability"] = Rounded(answer.probability, 4);
  json["image"] = answer.image;
  json["map"] = answer.map;
  json["map_version"] = answer.map_version;
  json["place"] = place ? ToJson(*place) : Json(nullptr);
  json["keyframe"] = answer.planes.keyframe ? KeyframeJson(*answer.planes.keyframe) : Json(nullptr);
  json["heading"] = answer.heading ? HeadingJson(*answer.heading) : Json(nullptr);
  AddPose(answer, json);
  if (answer.building) json["building"] = BuildingJson(*answer.building);
  json["planes"] = Json::array();
  for (const RecognisedPlane& plane : answer.planes.recognised) {
    json["planes"].push_back(PlaneJson(plane));
  }
  if (answer.planes.epipolar) json["epipolar"] = EpipolarJson(*answer.planes.epipolar);
  if (answer.panorama) json["panorama"] = PanoramaJson(*answer.panorama, place);
  if (answer.verdict == Verdict::kAmbiguous) {
    json["places"] = Json::array();
    for (const PlaceCandidate& alike : answer.planes.places)
      json["places"].push_back(ToJson(alike));
  }
  json["runner_up"] =
      answer.planes.runner_up ? RunnerUpJson(*answer.planes.runner_up) : Json(nullptr);
  json["decided_by"] = NameOf(answer.decided_by);
  if (answer.verdict != Verdict::kLocalized) json["message"] = answer.message;
  json["timing_ms"] = TimingJson(answer.timing);
  if (answer.planes.explanation) json["explanation"] = ToJson(*answer.planes.explanation);
  return json;
}

}  // namespace waystone
