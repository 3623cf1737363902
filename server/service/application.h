// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "core/base/options.h"
#include "server/http/server_names.h"
#include "server/http/tokens.h"
#include "server/service/jobs_service.h"
#include "server/service/localize_service.h"
#include "server/service/map_catalog.h"
#include "server/service/map_service.h"
#include "server/service/map_source.h"

namespace waystone {

struct ServiceOptions {
  LocalizeOptions localize;
  RequestLimits limits;
  int query_threads = 0;
  int queue_length = 32;
  // Who may ask. Empty: everybody.
  Tokens tokens;
  // By which names.
  ServerNames names = ServerNames();
  // Folder of the query log; empty for none.
  std::string query_log;
  int64_t query_log_bytes = 2'000'000'000;
  // The registry whose jobs are told; empty for none.
  std::string registry = {};

  static constexpr auto Fields(const auto& use) {
    using Self = ServiceOptions;
    return use(
        OptionGroup{"localize", &Self::localize}, OptionGroup{"limits", &Self::limits},
        OptionField{"query_threads", &Self::query_threads, Closed(0, 1024), "",
                    "Number of queries computed at once; 0 uses the number of cores. More threads "
                    "don't make answers faster; they only make them all arrive later."},
        OptionField{"queue_length", &Self::queue_length, Closed(0, 3000), "",
                    "Maximum number of waiting queries; further ones get 429. A longer queue turns "
                    "fewer queries away, but keeps the last ones waiting longer."},
        OptionField{"query_log_bytes", &Self::query_log_bytes, AtLeast(1), "bytes",
                    "Maximum size of the query log; logging ends when it is full."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// As many as there are cores where the options say 0.
int CountQueryThreads(const ServiceOptions& options);

// Everything behind the sockets: maps, queries, inspection, health and metrics, and around them who
// may ask, names of requests, logs and headers. Thread-safe.
class Application {
 public:
  struct Sinks {
    std::function<void(const std::string&)> access;  // one JSON object a request; may be empty
    std::function<void(const std::string&)> error;   // one line a mishap; may be empty
  };

  Application(std::shared_ptr<MapSource> maps, const ServiceOptions& options, Sinks sinks);
  // Of maps that stay.
  Application(const MapCatalog::Indices& maps, const ServiceOptions& options, Sinks sinks)
      : Application(std::make_shared<MapCatalog>(maps), options, std::move(sinks)) {}

  // Answers a request. Throws nothing but std::bad_alloc.
  HttpResponse Answer(const HttpRequest& request);

  Metrics& metrics() { return metrics_; }
  // From now on /readyz says that the server ends, so that a load balancer sends nothing more.
  void BeginStop() { stopping_ = true; }
  // Requests that wait for their turn, a map or a database are turned away from now on.
  void EndQueue() {
    gate_.Close();
    queries_.EndWaits();
    maps_->EndWaits();
    jobs_.EndWaits();
  }
  // Whether a request with this header Authorization may send a body. Thread-safe.
  bool Admit(const std::string& authorization) const {
    return options_.tokens.Admit(authorization);
  }

 private:
  void AddOperations();
  HttpResponse Admitted(const HttpRequest& request) const;
  HttpResponse Ready() const;
  void Report(const HttpRequest& request, const HttpResponse& response, double seconds);
  std::string NewId();

  ServiceOptions options_;
  Sinks sinks_;
  std::shared_ptr<MapSource> maps_;
  QueryGate gate_;
  Metrics metrics_;
  std::unique_ptr<QueryLog> log_;
  MapService inspection_;
  LocalizeService queries_;
  JobsService jobs_;
  Router router_;
  std::atomic<bool> stopping_ = false;
  std::string id_prefix_;  // of requests that have no name of their own
  std::atomic<uint64_t> requests_ = 0;
};

}  // namespace waystone
