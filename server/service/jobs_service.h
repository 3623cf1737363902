// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "api/json.h"
#include "core/base/clock.h"
#include "registry/job_queue.h"
#include "registry/registry.h"
#include "server/http/router.h"

namespace waystone {

// The jobs of a registry over HTTP, read by one connection: their list anew at most once a second,
// the details of one whenever they are asked for. Thread-safe.
class JobsService {
 public:
  // `registry` in PostgreSQL; any other, or an empty one, has no jobs to tell of.
  // `on_error` hears why the database doesn't answer, which is no concern of clients.
  JobsService(std::string registry, std::function<void(const std::string&)> on_error)
      : registry_(std::move(registry)), on_error_(std::move(on_error)) {}

  // Whether there is a registry with jobs.
  bool available() const { return IsPostgres(registry_); }

  // Adds the routes. The service must outlive the router's last request.
  void AddTo(Router& router);

  // Ends the waits for the database, now and from now on.
  void EndWaits() { stop_.request_stop(); }

 private:
  HttpResponse List(const HttpRequest& request);
  HttpResponse Show(const std::string& id);
  // Calls `ask` with the lock held, on a connection that is made anew where it broke. Throws
  // MapError(kRegistryUnavailable) for a database that doesn't answer, kNotAvailable for no such
  // registry.
  template <class Ask>
  auto AskQueue(const Ask& ask);

  const std::string registry_;
  const std::function<void(const std::string&)> on_error_;
  std::stop_source stop_;
  std::timed_mutex mutex_;
  std::unique_ptr<JobQueue> queue_;
  std::vector<Json> jobs_;  // as they were at `read_`
  Clock::time_point read_;
  std::string failure_;  // why the last question had no answer; empty where it had one
  Clock::time_point failed_;
};

}  // namespace waystone
