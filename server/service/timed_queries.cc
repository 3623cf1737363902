// SPDX-License-Identifier: Apache-2.0
#include "server/service/timed_queries.h"

#include <chrono>
#include <future>
#include <thread>
#include <utility>

#include "server/http/start_thread.h"

namespace waystone {
namespace {

// For a query that notices its deadline itself: its answer says more.
constexpr std::chrono::milliseconds kGrace{25};

}  // namespace

TimedQueries::~TimedQueries() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return computing_ == 0; });
}

void TimedQueries::Enter() {
  const std::lock_guard lock(mutex_);
  ++computing_;
}

void TimedQueries::Leave() {
  const std::lock_guard lock(mutex_);
  --computing_;
  changed_.notify_all();  // with the lock held: the destructor ends what is notified
}

RequestAnswer TimedQueries::Ask(const std::shared_ptr<const Session>& session,
                                QueryGate::Turn turn) {
  if (!session->deadline()) return session->Ask();
  std::promise<RequestAnswer> promise;
  std::future<RequestAnswer> answer = promise.get_future();
  Enter();
  const auto compute = [this, session](std::promise<RequestAnswer> promised,
                                       std::optional<QueryGate::Turn> held) {
    try {
      promised.set_value(session->Ask());
    } catch (...) {
      promised.set_exception(std::current_exception());
    }
    held.reset();
    Leave();
  };
  try {
    StartThread(compute, std::move(promise), std::optional(std::move(turn))).detach();
  } catch (...) {
    Leave();
    throw;
  }
  if (answer.wait_until(*session->deadline() + kGrace) == std::future_status::ready) {
    return answer.get();
  }
  return session->TimeOut();
}

}  // namespace waystone
