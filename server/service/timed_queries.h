// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "core/base/start_thread.h"
#include "localizer/session.h"
#include "server/service/query_gate.h"

namespace waystone {

// Keeps the deadlines of queries. A query checks its deadline between its stages; the longest ones
// (decoding, features) can't be interrupted, so a query with a deadline computes in a thread of its
// own, which nobody waits for any longer once the deadline has passed. Such a query keeps its turn
// until it ends, so that no more queries compute at once than may. Thread-safe.
class TimedQueries {
 public:
  TimedQueries() = default;
  ~TimedQueries();  // waits until all queries have ended
  TimedQueries(const TimedQueries&) = delete;
  TimedQueries& operator=(const TimedQueries&) = delete;

  // The session's answer, or from 25 ms after its deadline on the answer of a query that ran out of
  // time. Throws what Session::Ask throws.
  RequestAnswer Ask(const std::shared_ptr<const Session>& session, QueryGate::Turn turn);

  // What `compute` returns, or nothing from 25 ms after the deadline on; it then goes on in its own
  // thread, and keeps its turn. Throws what it throws.
  template <class Result>
  std::optional<Result> Run(const QueryGate::Deadline& deadline, QueryGate::Turn turn,
                            std::function<Result()> compute) {
    if (!deadline) return compute();
    std::promise<Result> promise;
    std::future<Result> result = promise.get_future();
    Enter();
    const auto run = [this, compute = std::move(compute)](std::promise<Result> promised,
                                                          std::optional<QueryGate::Turn> held) {
      try {
        promised.set_value(compute());
      } catch (...) {
        promised.set_exception(std::current_exception());
      }
      held.reset();
      Leave();
    };
    try {
      StartThread(run, std::move(promise), std::optional(std::move(turn))).detach();
    } catch (...) {
      Leave();
      throw;
    }
    if (result.wait_until(*deadline + kGrace) == std::future_status::ready) return result.get();
    return std::nullopt;
  }

 private:
  // For a query that notices its deadline itself, whose answer says more.
  static constexpr std::chrono::milliseconds kGrace{25};

  void Enter();
  void Leave();

  std::mutex mutex_;
  std::condition_variable changed_;
  int computing_ = 0;
};

}  // namespace waystone
