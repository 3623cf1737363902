// SPDX-License-Identifier: Apache-2.0
#include "server/http/request_answer.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/base/error.h"
#include "server/http/answer_json.h"

namespace waystone {
namespace {

constexpr int kDefaultMaps = 5;  // listed across maps unless top_k says how many

// How much an answer says, the most first.
int RankOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kLocalized:
      return 0;
    case Verdict::kAmbiguous:
      return 1;
    case Verdict::kNotInMap:
      return 2;
    case Verdict::kUndecided:
      return 3;
    case Verdict::kBadImage:
      return 4;
  }
  WS_CHECK(false, "unknown verdict");
}

bool IsBetter(const Answer& a, const Answer& b) {
  if (a.verdict != b.verdict) return RankOf(a.verdict) < RankOf(b.verdict);
  return a.probability > b.probability;
}

std::span<const uint8_t> BytesOf(const QueryImage& image) {
  return {reinterpret_cast<const uint8_t*>(image.bytes.data()), image.bytes.size()};
}

std::vector<Answer> AskMaps(const QueryImage& image, const ServedMaps& maps,
                            const LocalizeOptions& options) {
  if (maps.size() == 1) {
    return {Localize(maps.front()->index(), BytesOf(image), image.name, options)};
  }
  std::vector<const MapIndex*> indices;
  for (const auto& map : maps) indices.push_back(&map->index());
  return LocalizeAcross(indices, BytesOf(image), image.name, options);
}

size_t BestImage(const RequestAnswer& answer) {
  size_t best = 0;
  for (size_t i = 1; i < answer.images.size(); ++i) {
    if (IsBetter(answer.images[i].front(), answer.images[best].front())) best = i;
  }
  return best;
}

Json KeyframeShortJson(const Answer& answer) {
  if (!answer.keyframe) return nullptr;
  return {{"id", answer.keyframe->id.value},
          {"sequence", answer.keyframe->sequence},
          {"source", answer.keyframe->source}};
}

Json ShortJson(const Answer& answer, const char* key, const std::string& name) {
  Json json;
  json[key] = name;
  json["verdict"] = NameOf(answer.verdict);
  json["probability"] = Rounded(answer.probability, 4);
  json["keyframe"] = KeyframeShortJson(answer);
  json["inliers"] = answer.planes.empty() ? 0 : answer.planes.front().inliers;
  return json;
}

Json MapsJson(const std::vector<Answer>& answers, int limit) {
  Json list = Json::array();
  for (const Answer& answer : answers) {
    if (list.size() == static_cast<size_t>(limit)) break;
    list.push_back(ShortJson(answer, "map", answer.map));
  }
  return list;
}

Json CandidatesJson(const Answer& answer, int limit) {
  Json list = Json::array();
  for (const PlaceCandidate& place : answer.candidates) {
    if (list.size() == static_cast<size_t>(limit)) break;
    list.push_back(ToJson(place));
  }
  return list;
}

Json CameraJson(const LocalizeRequest& request, const Camera& camera) {
  const char* source = request.stored_camera ? "stored"
                       : request.fov_rad     ? "fov"
                       : request.intrinsics  ? "intrinsics"
                                             : "exif";
  return {{"source", source},
          {"model", NameOf(camera.model)},
          {"width", camera.width},
          {"height", camera.height},
          {"params", camera.params}};
}

Json UnusedJson(const LocalizeRequest& request) {
  Json unused = Json::array();
  if (request.intrinsics || request.fov_rad || request.stored_camera) unused.push_back("camera");
  if (request.prior_keyframe) unused.push_back("prior");
  if (!request.previous.is_null()) unused.push_back("previous");
  return unused;
}

}  // namespace

RequestAnswer AnswerRequest(const LocalizeRequest& request, const ServedMaps& maps,
                            const LocalizeOptions& options) {
  RequestAnswer result;
  for (const QueryImage& image : request.images) {
    std::vector<Answer> answers = AskMaps(image, maps, options);
    // Over HTTP a map goes by the name in the path, whatever it was called when it was built.
    for (size_t i = 0; i < maps.size(); ++i) answers[i].map = maps[i]->name();
    std::stable_sort(answers.begin(), answers.end(), IsBetter);
    result.images.push_back(std::move(answers));
  }
  result.best = BestImage(result);
  return result;
}

RequestAnswer LateAnswer(const LocalizeRequest& request, const ServedMaps& maps) {
  RequestAnswer result;
  for (const QueryImage& image : request.images) {
    std::vector<Answer>& answers = result.images.emplace_back();
    for (const auto& map : maps) {
      Answer& answer = answers.emplace_back();
      answer.verdict = Verdict::kUndecided;
      answer.image = image.name;
      answer.map = map->name();
      answer.map_version = map->version();
      answer.decided_by = "deadline";
      answer.stage = "queue";
      answer.message = "the deadline passed in the queue; ask with a later one or less often";
    }
  }
  return result;
}

Answer OverallAnswer(const RequestAnswer& answer) {
  const std::vector<Answer>& maps = answer.images.at(answer.best);
  Answer best = maps.front();
  const auto localized = std::count_if(maps.begin(), maps.end(), [](const Answer& map) {
    return map.verdict == Verdict::kLocalized;
  });
  if (localized < 2) return best;
  best.verdict = Verdict::kAmbiguous;
  best.decided_by = "ambiguous_maps";
  best.message = std::to_string(localized) +
                 " maps have this place; `maps` ranks them, ask one of them for its answer";
  for (int i = 0; i < localized; ++i) {
    const int inliers = maps[i].planes.empty() ? 0 : maps[i].planes.front().inliers;
    best.places.push_back({*maps[i].keyframe, maps[i].probability, inliers});
  }
  best.keyframe.reset();
  return best;
}

Json ToJson(const LocalizeRequest& request, const RequestAnswer& answer, bool across,
            const std::optional<Camera>& camera) {
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
  if (!overall.stage.empty()) json["stage"] = overall.stage;
  if (camera) json["camera"] = CameraJson(request, *camera);
  const Json unused = UnusedJson(request);
  if (!unused.empty()) json["unused"] = unused;
  return json;
}

}  // namespace waystone
