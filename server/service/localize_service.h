// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/query_request_json.h"
#include "localizer/options.h"
#include "localizer/session.h"
#include "server/http/router.h"
#include "server/service/map_search.h"
#include "server/service/map_source.h"
#include "server/service/metrics.h"
#include "server/service/query_gate.h"
#include "server/service/query_log.h"
#include "server/service/timed_queries.h"

namespace waystone {

// The queries over HTTP: POST /v1/maps/{map}/localize and POST /v1/localize. A handler first reads
// and parses the whole body, so that a slow client doesn't hold a query's turn, then waits for its
// turn, asks the localizer and renders the answer. Parsing JSON takes up to six times the body's
// memory, so one such body is parsed at a time; the deadline runs meanwhile, and a request that has
// waited for 20 s gets BusyError. Where the maps can't all be asked at once, the coarse index says
// which ones are (map_search.h). Thread-safe.
class LocalizeService {
 public:
  // All but the options and limits must outlive the service; `log` may be null.
  LocalizeService(MapSource& maps, QueryGate& gate, Metrics& metrics, QueryLog* log,
                  const LocalizeOptions& options, const RequestLimits& limits)
      : maps_(maps),
        gate_(gate),
        metrics_(metrics),
        log_(log),
        options_(options),
        limits_(limits) {}

  // Adds the routes. The service must outlive the router's last request.
  void AddTo(Router& router);

  // Turns away requests that wait for their JSON to be parsed, now and from now on.
  void EndWaits() { parsing_json_.Close(); }

 private:
  static constexpr int kMaxParsers = 10'000;  // as many threads as requests may have

  QueryRequest Read(const HttpRequest& http);
  // A request and its answer.
  struct Answered {
    std::shared_ptr<const QueryRequest> request;
    Json json;
  };
  // The map of that name, or all maps of the scope that can be had, opened by the request's
  // deadline.
  FoundMaps MapsFor(const std::optional<std::string>& name, const SearchScope& scope,
                    const QueryRequest& request);
  Answered AskMaps(const std::optional<std::string>& name, const SearchScope& scope,
                   QueryRequest request);
  HttpResponse Respond(const HttpRequest& http, const std::optional<std::string>& name,
                       const Answered& answered);
  HttpResponse Answer(const HttpRequest& http, const std::optional<std::string>& name);

  MapSource& maps_;
  QueryGate& gate_;
  Metrics& metrics_;
  QueryLog* log_;
  LocalizeOptions options_;
  RequestLimits limits_;
  QueryGate parsing_json_{1, kMaxParsers};
  TimedQueries computing_;
};

}  // namespace waystone
