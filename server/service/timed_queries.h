// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>

#include "localizer/session.h"
#include "server/service/query_gate.h"

namespace waystone {

// Keeps the deadlines of queries. A query looks at its deadline between its stages; the longest
// ones (decoding, features) can't be interrupted, so a query with a deadline computes in a thread
// of its own, which nobody waits for any longer once the deadline has passed. Such a query keeps
// its turn until it ends, so that no more queries compute at once than may. Thread-safe.
class TimedQueries {
 public:
  TimedQueries() = default;
  ~TimedQueries();  // waits until all queries have ended
  TimedQueries(const TimedQueries&) = delete;
  TimedQueries& operator=(const TimedQueries&) = delete;

  // The session's answer, at most 25 ms after its deadline: from then on that of a query that ran
  // out of time. Throws what Session::Ask throws.
  RequestAnswer Ask(const std::shared_ptr<const Session>& session, QueryGate::Turn turn);

 private:
  void Enter();
  void Leave();

  std::mutex mutex_;
  std::condition_variable changed_;
  int computing_ = 0;
};

}  // namespace waystone
