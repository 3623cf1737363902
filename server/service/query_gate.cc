// SPDX-License-Identifier: Apache-2.0
#include "server/service/query_gate.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "core/base/check.h"
#include "server/http/problem.h"

namespace waystone {

QueryGate::Turn QueryGate::Enter() {
  std::optional<Turn> turn = Enter(std::nullopt);
  WS_CHECK(turn.has_value(), "a wait without a deadline ended without a turn");
  return std::move(*turn);
}

std::optional<QueryGate::Turn> QueryGate::Enter(const Deadline& deadline) {
  std::unique_lock lock(mutex_);
  if (closed_) FailClosed();
  if (free_ > 0) {
    --free_;
    return std::optional<Turn>(std::in_place, this);
  }
  if (std::ssize(waiting_) >= seats_) {
    const int wait_s = RetryAfterS();
    throw BusyError("all query threads are busy and the queue is full; retry in " +
                        std::to_string(wait_s) + " s",
                    wait_s);
  }
  const auto place = waiting_.emplace(waiting_.end());
  const auto called = [&] { return place->called || closed_; };
  if (deadline) {
    place->changed.wait_until(lock, *deadline, called);
  } else {
    place->changed.wait(lock, called);
  }
  const bool has_turn = place->called;
  waiting_.erase(place);
  if (has_turn) return std::optional<Turn>(std::in_place, this);
  if (closed_) FailClosed();
  return std::nullopt;
}

void QueryGate::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  for (Place& place : waiting_) place.changed.notify_one();
}

void QueryGate::FailClosed() {
  throw MapError(ErrorCode::kNotReady, "the server is shutting down");
}

QueryGate::Load QueryGate::load() const {
  const std::lock_guard lock(mutex_);
  return {running_ - free_, static_cast<int>(waiting_.size())};
}

int QueryGate::RetryAfterS() const {
  constexpr double kLongestS = 60;
  const double rounds = (static_cast<double>(waiting_.size()) + 1) / running_;
  return static_cast<int>(std::clamp(std::ceil(rounds * turn_s_), 1.0, kLongestS));
}

// The turn goes to whoever has waited longest.
void QueryGate::Leave(Clock::duration took) {
  constexpr double kNewest = 0.2;  // weight of the last turn
  const double took_s = std::chrono::duration<double>(took).count();
  const std::lock_guard lock(mutex_);
  turn_s_ = turn_s_ > 0 ? (1 - kNewest) * turn_s_ + kNewest * took_s : took_s;
  const auto next = std::ranges::find(waiting_, false, &Place::called);
  if (next == waiting_.end()) {
    ++free_;
    return;
  }
  next->called = true;
  next->changed.notify_one();
}

}  // namespace waystone
