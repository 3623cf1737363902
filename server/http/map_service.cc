// SPDX-License-Identifier: Apache-2.0
#include "server/http/map_service.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "server/http/answer_json.h"
#include "server/http/home_page.h"
#include "server/http/map_json.h"
#include "server/http/paging.h"

namespace waystone {
namespace {

// Longest name of a query that an answer repeats.
constexpr size_t kMaxNameBytes = 200;

HttpResponse JsonResponse(const Json& json) {
  return {200, "application/json", Dump(json) + "\n", {}};
}

// The id in the path. What isn't a number isn't an id of anything.
int64_t IdIn(const Router::Captures& captures, const std::string& kind) {
  const std::string& text = captures.at("id");
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw MapError(ErrorCode::kNotFound, "there is no " + kind + " '" + text.substr(0, 40) +
                                             "' in this map; ids are numbers");
  }
  return value;
}

template <class T>
const T& Existing(const T* found, const std::string& kind, int64_t id) {
  if (!found) {
    throw MapError(ErrorCode::kNotFound,
                   "there is no " + kind + " " + std::to_string(id) + " in this map");
  }
  return *found;
}

const Keyframe& KeyframeOf(const MapIndex& index, const Router::Captures& captures) {
  const int64_t id = IdIn(captures, "keyframe");
  return Existing(index.FindKeyframe(KeyframeId{id}), "keyframe", id);
}

// What an image may be called. A form is what curl calls any body when it isn't told otherwise, so a
// photo sent the shortest way comes as one.
void CheckMediaType(const HttpRequest& request) {
  const std::optional<std::string> given = request.header("Content-Type");
  if (!given) return;
  std::string type;  // without parameters, in small letters
  for (const char c : *given) {
    if (c == ';' || c == ' ') break;
    type += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  const bool taken = type.empty() || type.starts_with("image/") ||
                     type == "application/octet-stream" ||
                     type == "application/x-www-form-urlencoded";
  if (taken) return;
  throw MapError(ErrorCode::kUnsupportedMedia,
                 "'" + type.substr(0, 80) +
                     "' is no image; send the file's bytes as Content-Type: image/jpeg");
}

std::string NameOfQuery(const HttpRequest& request) {
  const auto it = request.query.find("name");
  return it == request.query.end() ? "query" : it->second.substr(0, kMaxNameBytes);
}

// Whether the client has this version already (RFC 9110: a list of tags, or "*").
bool Has(const HttpRequest& request, const std::string& etag) {
  const std::string tags = request.header("If-None-Match").value_or("");
  return tags == "*" || tags.find(etag) != std::string::npos;
}

int ThreadsOf(const ServiceOptions& options) {
  if (options.query_threads > 0) return options.query_threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

void ServiceOptions::Check() const {
  localize.Check();
  if (query_threads < 0 || query_threads > 1024) {
    throw MapError(ErrorCode::kBadOptions, "query_threads must be 0 (all cores) to 1024");
  }
  if (queue_length < 0 || queue_length > 100'000) {
    throw MapError(ErrorCode::kBadOptions, "queue_length must be 0 to 100000");
  }
}

MapService::MapService(Maps maps, const ServiceOptions& options)
    : maps_(std::move(maps)),
      options_((options.Check(), options)),
      gate_(ThreadsOf(options), options.queue_length) {}

const MapIndex& MapService::MapOf(const Captures& captures) const {
  const auto it = maps_.find(captures.at("map"));
  if (it == maps_.end()) {
    throw MapError(ErrorCode::kNotFound, "there is no map '" + captures.at("map").substr(0, 80) +
                                             "' here; GET /v1/maps lists them");
  }
  return *it->second;
}

void MapService::AddTo(Router& router) {
  router.Add("GET", "/", [this](const auto& request, const auto&) { return Home(request); });
  router.Add("GET", "/healthz", [](const auto&, const auto&) {
    return HttpResponse{200, "text/plain", "ok\n", {}};
  });
  router.Add("GET", "/v1/maps",
             [this](const auto& request, const auto&) { return ListMaps(request); });

  // What shows a map never changes while the map's version doesn't.
  using Show = std::function<HttpResponse(const HttpRequest&, const Captures&)>;
  const auto add = [&](const std::string& pattern, const Show& show) {
    router.Add("GET", "/v1/maps/{map}" + pattern,
               [this, show](const HttpRequest& request, const Captures& captures) {
                 const std::string etag = "\"" + MapOf(captures).map().info.version + "\"";
                 // First the answer: a 304 for what isn't there would be a lie.
                 HttpResponse response = show(request, captures);
                 if (Has(request, etag)) response = {304, "", "", {}};
                 response.headers.emplace_back("ETag", etag);
                 response.headers.emplace_back("Cache-Control", "no-cache");
                 return response;
               });
  };
  add("", [this](const auto&, const auto& in) { return ShowMap(in); });
  add("/planes", [this](const auto& request, const auto& in) { return ListPlanes(request, in); });
  add("/planes/{id}", [this](const auto&, const auto& in) { return ShowPlane(in); });
  add("/graph", [this](const auto&, const auto& in) { return ShowGraph(in); });
  add("/keyframes",
      [this](const auto& request, const auto& in) { return ListKeyframes(request, in); });
  add("/keyframes/{id}", [this](const auto&, const auto& in) { return ShowKeyframe(in); });
  add("/keyframes/{id}/image", [this](const auto&, const auto& in) { return ShowImage(in); });
  router.Add("POST", "/v1/maps/{map}/localize",
             [this](const auto& request, const auto& in) { return Localize(request, in); });
}

HttpResponse MapService::Home(const HttpRequest& request) const {
  std::vector<std::string> names;
  for (const auto& [name, index] : maps_) names.push_back(name);
  HttpResponse response{200,
                        "text/html; charset=utf-8",
                        HomePage(names, request.header("Host").value_or("localhost")),
                        {}};
  response.headers.emplace_back("Content-Security-Policy",
                                "default-src 'none'; style-src 'unsafe-inline'");
  return response;
}

HttpResponse MapService::ListMaps(const HttpRequest& request) const {
  const Page page = PageOf(request, maps_.size());
  Json json;
  json["maps"] = Json::array();
  auto it = std::next(maps_.begin(), static_cast<int64_t>(page.begin));
  for (size_t i = page.begin; i < page.end; ++i, ++it) {
    json["maps"].push_back(MapJson(it->first, *it->second));
  }
  json["next"] = page.next.empty() ? Json(nullptr) : Json(page.next);
  return JsonResponse(json);
}

HttpResponse MapService::ShowMap(const Captures& captures) const {
  return JsonResponse(MapJson(captures.at("map"), MapOf(captures)));
}

HttpResponse MapService::ListPlanes(const HttpRequest& request, const Captures& captures) const {
  const MapIndex& index = MapOf(captures);
  const std::vector<Plane>& planes = index.map().planes;
  const Page page = PageOf(request, planes.size());
  Json json;
  json["planes"] = Json::array();
  for (size_t i = page.begin; i < page.end; ++i) {
    json["planes"].push_back(PlaneSummaryJson(index, planes[i]));
  }
  json["next"] = page.next.empty() ? Json(nullptr) : Json(page.next);
  return JsonResponse(json);
}

HttpResponse MapService::ShowPlane(const Captures& captures) const {
  const MapIndex& index = MapOf(captures);
  const int64_t id = IdIn(captures, "plane");
  return JsonResponse(PlaneJson(index, Existing(index.FindPlane(PlaneId{id}), "plane", id)));
}

HttpResponse MapService::ShowGraph(const Captures& captures) const {
  return JsonResponse(GraphJson(MapOf(captures)));
}

HttpResponse MapService::ListKeyframes(const HttpRequest& request, const Captures& captures) const {
  const MapIndex& index = MapOf(captures);
  const std::vector<Keyframe>& keyframes = index.map().keyframes;
  const Page page = PageOf(request, keyframes.size());
  Json json;
  json["keyframes"] = Json::array();
  for (size_t i = page.begin; i < page.end; ++i) {
    json["keyframes"].push_back(KeyframeJson(captures.at("map"), index, keyframes[i]));
  }
  json["next"] = page.next.empty() ? Json(nullptr) : Json(page.next);
  return JsonResponse(json);
}

HttpResponse MapService::ShowKeyframe(const Captures& captures) const {
  const MapIndex& index = MapOf(captures);
  return JsonResponse(KeyframeJson(captures.at("map"), index, KeyframeOf(index, captures)));
}

HttpResponse MapService::ShowImage(const Captures& captures) const {
  const Keyframe& keyframe = KeyframeOf(MapOf(captures), captures);
  if (keyframe.jpeg.empty()) {
    throw MapError(ErrorCode::kNotFound,
                   "this map was built without images; build it again without --no-images");
  }
  return {200, "image/jpeg", std::string(keyframe.jpeg.begin(), keyframe.jpeg.end()), {}};
}

HttpResponse MapService::Localize(const HttpRequest& request, const Captures& captures) {
  const MapIndex& index = MapOf(captures);
  CheckMediaType(request);
  // The whole body first: a slow client must not hold a query's turn.
  const std::string body = request.read_body();
  const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(body.data()), body.size());
  const QueryGate::Turn turn = gate_.Enter();
  Answer answer = waystone::Localize(index, bytes, NameOfQuery(request), options_.localize);
  // Over HTTP a map goes by the name in the path, whatever it was called when it was built.
  answer.map = captures.at("map");
  return JsonResponse(ToJson(answer));
}

}  // namespace waystone
