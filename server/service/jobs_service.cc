// SPDX-License-Identifier: Apache-2.0
#include "server/service/jobs_service.h"

#include <chrono>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "server/http/paging.h"
#include "server/http/responses.h"

namespace waystone {
namespace {

constexpr int kMostJobs = 1000;
constexpr double kFreshS = 1;
// For a request that waits for another one's answer.
constexpr std::chrono::seconds kLongestWait(2);

MapError NoDatabase() {
  return {ErrorCode::kRegistryUnavailable,
          "the registry's database doesn't answer; the server's log says why"};
}

}  // namespace

void JobsService::AddTo(Router& router) {
  router.Add("GET", "/v1/jobs",
             [this](const HttpRequest& request, const auto&) { return List(request); });
  router.Add("GET", "/v1/jobs/{id}",
             [this](const auto&, const Router::Captures& in) { return Show(in.at("id")); });
}

template <class Ask>
auto JobsService::AskQueue(const Ask& ask) {
  if (!available()) {
    throw MapError(ErrorCode::kNotAvailable,
                   "this server has no registry in PostgreSQL, and so no jobs");
  }
  const std::unique_lock lock(mutex_, kLongestWait);
  if (!lock.owns_lock()) {
    throw MapError(ErrorCode::kRegistryUnavailable,
                   "the registry's database is slow; try again in a moment");
  }
  if (!failure_.empty() && SecondsSince(failed_) < kFreshS) throw NoDatabase();
  try {
    if (!queue_) queue_ = std::make_unique<JobQueue>(registry_, false, stop_.get_token());
    auto answer = ask(*queue_);
    failure_.clear();
    return answer;
  } catch (const MapError& error) {
    const bool passes = error.code() == ErrorCode::kRegistryUnavailable ||
                        error.code() == ErrorCode::kFileUnreadable;
    if (!passes) throw;
    queue_.reset();
    if (failure_ != error.what()) on_error_(error.what());
    failure_ = error.what();
    failed_ = Clock::now();
    throw NoDatabase();
  }
}

HttpResponse JobsService::List(const HttpRequest& request) {
  return JsonResponse(AskQueue([&](JobQueue& queue) {
    if (read_ == Clock::time_point() || SecondsSince(read_) >= kFreshS) {
      jobs_ = queue.List(kMostJobs);
      read_ = Clock::now();
    }
    std::vector<int64_t> ids;
    for (const Json& job : jobs_) ids.push_back(job.at("id").get<int64_t>());
    return PagedJson(PageOf(request, ids), "jobs", [&](size_t i) { return jobs_[i]; });
  }));
}

HttpResponse JobsService::Show(const std::string& id) {
  const std::optional<int64_t> job = ToInteger(id);
  return JsonResponse(AskQueue([&](JobQueue& queue) {
    if (!job || *job <= 0) {
      throw MapError(ErrorCode::kNotFound, "no job '" + Printable(id.substr(0, 40)) +
                                               "' in this registry; ids are positive integers");
    }
    return queue.Describe(*job);
  }));
}

}  // namespace waystone
