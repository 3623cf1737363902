// SPDX-License-Identifier: Apache-2.0
#include "server/service/localize_service.h"

#include <memory>
#include <optional>
#include <utility>

#include "api/request_answer_json.h"
#include "core/base/error.h"
#include "localizer/session.h"
#include "server/http/responses.h"
#include "server/service/localize_request.h"

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

}  // namespace

void LocalizeService::AddTo(Router& router) {
  router.Add("POST", "/v1/maps/{map}/localize",
             [this](const HttpRequest& http, const Router::Captures& captures) {
               return Answer(http, {catalog_.Find(captures.at("map"))}, false);
             });
  router.Add("POST", "/v1/localize", [this](const HttpRequest& http, const Router::Captures&) {
    ServedMaps maps;
    for (const auto& [name, map] : *catalog_.Now()) maps.push_back(map);
    if (maps.empty()) throw MapError(ErrorCode::kNotReady, "no maps loaded");
    return Answer(http, maps, true);
  });
}

QueryRequest LocalizeService::Read(const HttpRequest& http) {
  const Clock::time_point received = Clock::now();
  std::unique_lock turn(parsing_json_, std::defer_lock);
  if (IsJson(http)) turn.lock();
  QueryRequest request = ReadQueryRequest(http, limits_);
  request.received = received;
  return request;
}

HttpResponse LocalizeService::Answer(const HttpRequest& http, const ServedMaps& maps, bool across) {
  QueryRequest request = Read(http);
  if (across) RefuseMapsOwn(request);
  std::vector<QueriedMap> queried;
  for (const auto& map : maps) queried.push_back({map->name(), map->shared_index()});
  const auto session =
      std::make_shared<const Session>(std::move(request), std::move(queried), options_);
  std::optional<QueryGate::Turn> turn = gate_.Enter(session->deadline());
  const RequestAnswer answer =
      turn ? computing_.Ask(session, std::move(*turn)) : session->TimeOut();
  metrics_.CountAnswer(OverallAnswer(answer));
  const Json json = ToJson(*session, answer, across);
  if (log_) {
    log_->Add(http.id, across ? Json(nullptr) : Json(maps.front()->name()), session->request(),
              json);
  }
  return JsonResponse(json);
}

}  // namespace waystone
