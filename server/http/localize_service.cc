// SPDX-License-Identifier: Apache-2.0
#include "server/http/localize_service.h"

#include <chrono>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "server/http/request_answer.h"
#include "server/http/responses.h"

namespace waystone {
namespace {

void RefuseMapsOwn(const LocalizeRequest& request) {
  if (request.prior_keyframe || !request.previous.is_null() || request.stored_camera ||
      !request.odometry.empty()) {
    throw MapError(
        ErrorCode::kBadRequest,
        "camera, prior, previous and odometry refer to one map; use /v1/maps/{map}/localize");
  }
}

void CheckPrior(const LocalizeRequest& request, const MapIndex& index) {
  if (!request.prior_keyframe || index.FindKeyframe(KeyframeId{*request.prior_keyframe})) return;
  throw MapError(ErrorCode::kBadRequest,
                 "prior: the map has no keyframe " + std::to_string(*request.prior_keyframe));
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

HttpResponse LocalizeService::Answer(const HttpRequest& http, const ServedMaps& maps, bool across) {
  const LocalizeRequest request = ReadLocalizeRequest(http, limits_);
  if (across) {
    RefuseMapsOwn(request);
  } else {
    CheckPrior(request, maps.front()->index());
  }
  const std::optional<Camera> camera =
      CameraFor(request, maps.front()->index().map(), request.images.front());
  LocalizeOptions options = options_;
  options.explain = request.debug;
  options.camera = camera;
  if (request.deadline_ms) {
    options.deadline =
        std::chrono::steady_clock::now() + std::chrono::milliseconds(*request.deadline_ms);
  }
  RequestAnswer answer;
  {
    const std::optional<QueryGate::Turn> turn = gate_.Enter(options.deadline);
    answer = turn ? AnswerRequest(request, maps, options) : LateAnswer(request, maps);
  }
  metrics_.CountAnswer(OverallAnswer(answer));
  const Json json = ToJson(request, answer, across, camera);
  if (log_) log_->Add(http.id, across ? Json(nullptr) : Json(maps.front()->name()), request, json);
  return JsonResponse(json);
}

}  // namespace waystone
