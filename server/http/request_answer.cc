// SPDX-License-Identifier: Apache-2.0
#include "server/http/request_answer.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "api/answer_json.h"
#include "core/base/error.h"
#include "localizer/appearance/appearance.h"

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

Json UnusedJson(const LocalizeRequest& request, const RequestAnswer& answer) {
  Json unused = Json::array();
  const bool has_camera = request.intrinsics || request.fov_rad || request.stored_camera;
  if (has_camera && !answer.used_camera) unused.push_back("camera");
  if (request.prior_keyframe) unused.push_back("prior");
  if (!request.previous.is_null() && !answer.used_previous) unused.push_back("previous");
  if (!request.odometry.empty() && !answer.series) unused.push_back("odometry");
  return unused;
}

// ---- panoramas

// By its header: what isn't an image fits either way.
bool LooksLikePhoto(const QueryImage& image) {
  try {
    const ImageHeader header = ReadImageHeader(BytesOf(image));
    return !IsPanoramic(cv::Size(header.width, header.height));
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage) throw;
    return false;
  }
}

// The belief of the request's previous answer; nothing without one of this version of the map.
std::optional<FilterState> PreviousBelief(const LocalizeRequest& request, const MapIndex& index) {
  const Json& previous = request.previous;
  if (previous.is_null() || !previous.contains("belief")) return std::nullopt;
  const MapData& map = index.map();
  if (previous.contains("map_version") && previous["map_version"] != map.info.version) {
    return std::nullopt;
  }
  const std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  FilterState belief;
  for (const Json& one : previous["belief"]) {
    const AppearanceNodeId id{one["node"].get<int64_t>()};
    const auto node = std::ranges::lower_bound(nodes, id, {}, &AppearanceNode::id);
    if (node == nodes.end() || node->id != id) {
      throw MapError(ErrorCode::kBadRequest, "previous.belief: the map has no panorama " +
                                                 std::to_string(id.value) +
                                                 "; omit `previous` after the map has changed");
    }
    belief.push_back({static_cast<int>(node - nodes.begin()), one["probability"].get<double>(),
                      one["heading_rad"].get<double>(), one["deviation_rad"].get<double>()});
  }
  return belief;
}

Json BeliefJson(const FilterState& belief, const MapIndex& index) {
  if (belief.empty()) return nullptr;
  Json list = Json::array();
  for (const Belief& one : belief) {
    // Rounded down, so that the sum can't exceed 1; what is nothing by then isn't worth its bytes.
    const double probability = std::floor(one.probability * 1e6) / 1e6;
    if (probability == 0) continue;
    list.push_back({{"node", index.map().appearance->nodes[one.node].id.value},
                    {"probability", probability},
                    {"heading_rad", Rounded(one.heading_rad, 5)},
                    {"deviation_rad", std::max(1e-5, Rounded(one.sigma_rad, 5))}});
  }
  return list;
}

// The images one after the other, each asked with what those before it showed.
RequestAnswer AnswerSeries(const LocalizeRequest& request, const ServedMap& map,
                           std::optional<FilterState> previous, const LocalizeOptions& options) {
  RequestAnswer result;
  result.series = true;
  result.used_previous = previous.has_value();
  SeriesContext context;
  if (previous) context.previous = std::move(*previous);
  for (size_t i = 0; i < request.images.size(); ++i) {
    const QueryImage& image = request.images[i];
    context.odometry = request.odometry.empty() ? std::nullopt : request.odometry[i];
    LocalizeOptions asked = options;
    asked.series = context;
    Answer answer = Localize(map.index(), BytesOf(image), image.name, asked);
    answer.map = map.name();
    if (answer.verdict != Verdict::kBadImage && answer.verdict != Verdict::kUndecided) {
      context.previous = answer.belief;
      result.best = i;
    }
    result.images.push_back({std::move(answer)});
  }
  result.belief = BeliefJson(context.previous, map.index());
  return result;
}

}  // namespace

RequestAnswer AnswerRequest(const LocalizeRequest& request, const ServedMaps& maps,
                            const LocalizeOptions& options) {
  const bool panoramas = maps.size() == 1 && maps.front()->index().HasAppearance();
  const auto photos = std::ranges::count_if(request.images, LooksLikePhoto);
  if (panoramas && photos == 0) {
    auto previous = PreviousBelief(request, maps.front()->index());
    if (previous || request.images.size() > 1) {
      return AnswerSeries(request, *maps.front(), std::move(previous), options);
    }
  }
  RequestAnswer result;
  result.used_camera = std::ranges::any_of(maps, [&](const auto& map) {
    const MapData& data = map->index().map();
    return data.orientation || (panoramas && photos > 0 && data.planes.empty());
  });
  for (const QueryImage& image : request.images) {
    std::vector<Answer> answers = AskMaps(image, maps, options);
    // Over HTTP a map goes by the name in the path, whatever it was called when it was built.
    for (size_t i = 0; i < maps.size(); ++i) answers[i].map = maps[i]->name();
    std::stable_sort(answers.begin(), answers.end(), IsBetter);
    result.images.push_back(std::move(answers));
  }
  result.best = BestImage(result);
  if (panoramas) {
    result.belief = BeliefJson(result.images[result.best].front().belief, maps.front()->index());
  }
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
      answer.message =
          "the deadline expired in the queue; use a longer deadline or send fewer queries";
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
  best.message =
      std::to_string(localized) +
      " maps contain this place; `maps` ranks them, query one of them for its full answer";
  for (int i = 0; i < localized; ++i) {
    const int inliers = maps[i].planes.empty() ? 0 : maps[i].planes.front().inliers;
    // A panorama's place has no keyframe.
    if (maps[i].keyframe) best.places.push_back({*maps[i].keyframe, maps[i].probability, inliers});
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
  if (!answer.belief.is_null()) json["belief"] = answer.belief;
  if (!overall.stage.empty()) json["stage"] = overall.stage;
  if (camera) json["camera"] = CameraJson(request, *camera);
  const Json unused = UnusedJson(request, answer);
  if (!unused.empty()) json["unused"] = unused;
  return json;
}

}  // namespace waystone
