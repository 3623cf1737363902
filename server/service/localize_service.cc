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
               return Answer(http, captures.at("map"));
             });
  router.Add("POST", "/v1/localize", [this](const HttpRequest& http, const Router::Captures&) {
    return Answer(http, std::nullopt);
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

std::vector<QueriedMap> LocalizeService::MapsFor(const std::optional<std::string>& name,
                                                 const QueryRequest& request) {
  MapSource::Deadline deadline;
  if (request.deadline_ms) {
    deadline = request.received.value() + std::chrono::milliseconds(*request.deadline_ms);
  }
  std::vector<MapSource::MapPtr> maps;
  if (name) {
    maps.push_back(maps_.Find(*name, deadline));
  } else {
    maps = maps_.FindAll(deadline);
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
  const bool across = !name;
  if (across) RefuseMapsOwn(request);
  std::vector<QueriedMap> queried = MapsFor(name, request);
  const auto session =
      std::make_shared<const Session>(std::move(request), std::move(queried), options_);
  std::optional<QueryGate::Turn> turn = gate_.Enter(session->deadline());
  const RequestAnswer answer =
      turn ? computing_.Ask(session, std::move(*turn)) : session->TimeOut();
  metrics_.CountAnswer(OverallAnswer(answer));
  const Json json = ToJson(*session, answer, across);
  if (log_) {
    log_->Add(http.id, name ? Json(*name) : Json(nullptr), session->request(), json);
  }
  return JsonResponse(json);
}

}  // namespace waystone
