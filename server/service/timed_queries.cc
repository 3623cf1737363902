// SPDX-License-Identifier: Apache-2.0
#include "server/service/timed_queries.h"

namespace waystone {

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
  changed_.notify_all();  // with the lock held: the destructor may destroy it right after
}

RequestAnswer TimedQueries::Ask(const std::shared_ptr<const Session>& session,
                                QueryGate::Turn turn) {
  const std::optional<RequestAnswer> answer = Run<RequestAnswer>(
      session->deadline(), std::move(turn), [session] { return session->Ask(); });
  return answer ? *answer : session->TimeOut();
}

}  // namespace waystone
