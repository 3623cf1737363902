// SPDX-License-Identifier: Apache-2.0
#include "server/service/localize_service.h"

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "api/request_answer_json.h"
#include "core/base/error.h"
#include "localizer/session.h"
#include "server/http/responses.h"
#include "server/service/localize_request.h"
#include "server/service/map_search.h"

namespace waystone {
namespace {

void RefuseMapsOwn(const QueryRequest& request) {
  if (!request.prior_keyframe && !request.previous && !request.stored_camera &&
      request.odometry.empty()) {
    return;
  }
  throw MapError(
      ErrorCode::kBadRequest,
      "camera, prior, previous and odometry refer to one map; use /v1/maps/{map}/localize");
}

Json SearchedJson(const std::vector<SearchedMap>& searched) {
  Json list = Json::array();
  for (const SearchedMap& one : searched) {
    list.push_back({{"map", one.name}, {"state", one.state}, {"score", Rounded(one.score, 2)}});
    if (!one.message.empty()) list.back()["message"] = one.message;
  }
  return list;
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
  std::unique_lock turn(parsing_json_, std::defer_lock);
  if (IsJson(http)) turn.lock();
  QueryRequest request = ReadQueryRequest(http, limits_);
  request.received = http.received;
  return request;
}

std::vector<QueriedMap> LocalizeService::MapsFor(const std::optional<std::string>& name,
                                                 const SearchScope& scope,
                                                 const QueryRequest& request) {
  MapSource::Deadline deadline;
  if (request.deadline_ms) {
    deadline = request.received.value() + std::chrono::milliseconds(*request.deadline_ms);
  }
  std::vector<MapSource::MapPtr> maps;
  if (name) {
    maps.push_back(maps_.Find(*name, deadline));
  } else if (!request.hints) {
    maps = maps_.FindAll(deadline);
  } else {
    for (const std::string& one : scope.names) maps.push_back(maps_.Find(one, deadline));
  }
  std::vector<QueriedMap> queried;
  for (const MapSource::MapPtr& map : maps) {
    queried.push_back({map->name(), map->shared_index()});
  }
  return queried;
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
  json["searched"] = SearchedJson(search.searched);
  json["partial"] = search.IsPartial();
  if (search.unindexed > 0) json["unindexed"] = search.unindexed;
  return Respond(http, name,
                 {std::make_shared<const QueryRequest>(std::move(request)), std::move(json)});
}

LocalizeService::Answered LocalizeService::AskMaps(const std::optional<std::string>& name,
                                                   const SearchScope& scope, QueryRequest request) {
  std::vector<QueriedMap> queried = MapsFor(name, scope, request);
  const auto session =
      std::make_shared<const Session>(std::move(request), std::move(queried), options_);
  std::optional<QueryGate::Turn> turn = gate_.Enter(session->deadline());
  const RequestAnswer answer =
      turn ? computing_.Ask(session, std::move(*turn)) : session->TimeOut();
  metrics_.CountAnswer(OverallAnswer(answer));
  return {std::shared_ptr<const QueryRequest>(session, &session->request()),
          ToJson(*session, answer, !name)};
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
