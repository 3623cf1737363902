// SPDX-License-Identifier: Apache-2.0
#include "server/service/localize_service.h"

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "api/request_answer_json.h"
#include "core/base/error.h"
#include "localizer/session.h"
#include "server/http/problem.h"
#include "server/http/responses.h"
#include "server/service/localize_request.h"

namespace waystone {
namespace {

// Only the body tells the request's own deadline.
constexpr std::chrono::seconds kParsePatience{20};

void RefuseMapsOwn(const QueryRequest& request) {
  if (!request.prior_keyframe && !request.previous && !request.stored_camera &&
      request.odometry.empty()) {
    return;
  }
  throw MapError(
      ErrorCode::kBadRequest,
      "camera, prior, previous and odometry refer to one map; use /v1/maps/{map}/localize");
}

void AddSearched(const std::vector<SearchedMap>& searched, bool partial, Json& json) {
  Json& list = json["searched"] = Json::array();
  for (const SearchedMap& one : searched) {
    list.push_back({{"map", one.name}, {"state", one.state}, {"score", Rounded(one.score, 2)}});
    if (!one.message.empty()) list.back()["message"] = one.message;
  }
  json["partial"] = partial;
}

void RefuseHints(const QueryRequest& request) {
  if (!request.hints) return;
  throw MapError(ErrorCode::kBadRequest,
                 "hints narrow a query of all maps; use /v1/localize, or omit them");
}

}  // namespace

void LocalizeService::AddTo(Router& router) {
  router.Add("POST", "/v1/maps/{map}/localize",
             [this](const HttpRequest& http, const Router::Captures& captures) {
               return Answer(http, captures.at("map"));
             });
  router.Add("POST", "/v1/localize", [this](const HttpRequest& http, const Router::Captures&) {
    return Answer(http, std::nullopt);
  });
}

QueryRequest LocalizeService::Read(const HttpRequest& http) {
  const bool is_json = IsJson(http);
  const std::optional<QueryGate::Turn> turn =
      is_json ? parsing_json_.Enter(http.received + kParsePatience) : std::nullopt;
  if (is_json && !turn) {
    throw BusyError(
        "too many JSON bodies are waiting to be parsed; try again, or send plain images", 1);
  }
  QueryRequest request = ReadQueryRequest(http, limits_);
  request.received = http.received;
  return request;
}

FoundMaps LocalizeService::MapsFor(const std::optional<std::string>& name, const SearchScope& scope,
                                   const QueryRequest& request) {
  MapSource::Deadline deadline;
  if (request.deadline_ms) {
    deadline = request.received.value() + std::chrono::milliseconds(*request.deadline_ms);
  }
  if (!name) return FindMaps(scope, deadline, maps_);
  const MapSource::MapPtr map = maps_.Find(*name, deadline);
  return {{{map->name(), map->shared_index()}}, {}};
}

HttpResponse LocalizeService::Answer(const HttpRequest& http,
                                     const std::optional<std::string>& name) {
  if (name) maps_.CheckName(*name);
  QueryRequest request = Read(http);
  if (name) {
    RefuseHints(request);
    return Respond(http, name, AskMaps(name, {}, std::move(request)));
  }
  RefuseMapsOwn(request);
  const SearchScope scope = maps_.ScopeOf(request.hints.value_or(MapHints{}));
  if (!scope.coarse) return Respond(http, name, AskMaps(name, scope, std::move(request)));
  SearchAnswer search = SearchMaps(request, scope, options_, maps_, gate_, computing_);
  metrics_.CountAnswer(OverallAnswer(search.answer));
  Json json = ToJson(request, search.camera, search.answer, true);
  AddSearched(search.searched, search.IsPartial(), json);
  if (search.unindexed > 0) json["unindexed"] = search.unindexed;
  return Respond(http, name,
                 {std::make_shared<const QueryRequest>(std::move(request)), std::move(json)});
}

LocalizeService::Answered LocalizeService::AskMaps(const std::optional<std::string>& name,
                                                   const SearchScope& scope, QueryRequest request) {
  FoundMaps found = MapsFor(name, scope, request);
  const bool partial = IsPartial(found.searched);
  const auto session = std::make_shared<const Session>(std::move(request), std::move(found.queried),
                                                       options_, partial);
  std::optional<QueryGate::Turn> turn = gate_.Enter(session->deadline());
  const RequestAnswer answer =
      turn ? computing_.Ask(session, std::move(*turn)) : session->TimeOut();
  metrics_.CountAnswer(OverallAnswer(answer));
  Json json = ToJson(*session, answer, !name);
  if (partial) {
    TellLate(answer, found.searched);
    AddSearched(found.searched, true, json);
  }
  return {std::shared_ptr<const QueryRequest>(session, &session->request()), std::move(json)};
}

HttpResponse LocalizeService::Respond(const HttpRequest& http,
                                      const std::optional<std::string>& name,
                                      const Answered& answered) {
  if (log_) {
    log_->Add(http.id, name ? Json(*name) : Json(nullptr), *answered.request, answered.json);
  }
  return JsonResponse(answered.json);
}

}  // namespace waystone
