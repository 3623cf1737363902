// SPDX-License-Identifier: Apache-2.0
#include "api/request_answer_json.h"

#include "api/answer_json.h"
#include "api/query_request_json.h"

namespace waystone {
namespace {

constexpr int kDefaultMaps = 5;  // listed across maps unless top_k says how many

Json KeyframeShortJson(const Answer& answer) {
  if (!answer.planes.keyframe) return nullptr;
  return {{"id", answer.planes.keyframe->id.value},
          {"sequence", answer.planes.keyframe->sequence},
          {"source", answer.planes.keyframe->source}};
}

Json ShortJson(const Answer& answer, const char* key, const std::string& name) {
  Json json;
  json[key] = name;
  json["verdict"] = NameOf(answer.verdict);
  json["probability"] = Rounded(answer.probability, 4);
  const std::optional<AnsweredPlace> place = PlaceOf(answer);
  json["place"] = place ? ToJson(*place) : Json(nullptr);
  json["keyframe"] = KeyframeShortJson(answer);
  json["inliers"] = CountBestInliers(answer.planes);
  return json;
}

Json MapsJson(const std::vector<Answer>& answers, int limit) {
  Json list = Json::array();
  for (const Answer& answer : answers) {
    if (list.size() == static_cast<size_t>(limit)) break;
    if (answer.map.empty()) continue;  // of no map at all
    list.push_back(ShortJson(answer, "map", answer.map));
  }
  return list;
}

Json CandidatesJson(const Answer& answer, int limit) {
  Json list = Json::array();
  for (const PlaceCandidate& place : answer.planes.candidates) {
    if (list.size() == static_cast<size_t>(limit)) break;
    list.push_back(ToJson(place));
  }
  return list;
}

Json CameraJson(const QueryCamera& known) {
  const Camera& camera = known.camera;
  return {{"source", NameOf(known.source)},
          {"model", NameOf(camera.model)},
          {"width", camera.width},
          {"height", camera.height},
          {"params", camera.params}};
}

Json UnusedJson(const QueryRequest& request, const RequestAnswer& answer) {
  Json unused = Json::array();
  if (NamesCamera(request) && !answer.used_camera) unused.push_back("camera");
  if (request.prior_keyframe) unused.push_back("prior");
  if (request.previous && !answer.used_previous) unused.push_back("previous");
  if (!request.odometry.empty() && !answer.series) unused.push_back("odometry");
  return unused;
}

}  // namespace

Json ToJson(const Session& session, const RequestAnswer& answer, bool across) {
  return ToJson(session.request(), session.camera(), answer, across);
}

Json ToJson(const QueryRequest& request, const std::optional<QueryCamera>& camera,
            const RequestAnswer& answer, bool across) {
  const Answer overall = OverallAnswer(answer);
  Json json = ToJson(overall);
  if (across) {
    json["maps"] = MapsJson(answer.images[answer.best], request.top_k.value_or(kDefaultMaps));
  }
  if (answer.images.size() > 1) {
    json["images"] = Json::array();
    for (const std::vector<Answer>& image : answer.images) {
      json["images"].push_back(ShortJson(image.front(), "image", image.front().image));
    }
  }
  if (request.top_k) json["candidates"] = CandidatesJson(overall, *request.top_k);
  if (answer.belief) json["belief"] = ToJson(*answer.belief);
  if (overall.last_stage) json["stage"] = NameOf(*overall.last_stage);
  if (camera) json["camera"] = CameraJson(*camera);
  const Json unused = UnusedJson(request, answer);
  if (!unused.empty()) json["unused"] = unused;
  return json;
}

}  // namespace waystone
