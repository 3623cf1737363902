// SPDX-License-Identifier: Apache-2.0
#include "server/http/query_gate.h"

#include <algorithm>
#include <cmath>
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
  if (free_ == 0) {
    if (waiting_ >= seats_) {
      const int wait_s = RetryAfterS();
      throw BusyError("all query threads are busy and the queue is full; retry in " +
                          std::to_string(wait_s) + " s",
                      wait_s);
    }
    ++waiting_;
    const auto is_free = [this] { return free_ > 0; };
    if (deadline) {
      freed_.wait_until(lock, *deadline, is_free);
    } else {
      freed_.wait(lock, is_free);
    }
    --waiting_;
    if (free_ == 0) return std::nullopt;
  }
  --free_;
  return std::optional<Turn>(std::in_place, this);
}

QueryGate::Load QueryGate::load() const {
  const std::lock_guard lock(mutex_);
  return {running_ - free_, waiting_};
}

int QueryGate::RetryAfterS() const {
  constexpr double kLongestS = 60;
  const double rounds = (waiting_ + 1.0) / running_;
  return static_cast<int>(std::clamp(std::ceil(rounds * turn_s_), 1.0, kLongestS));
}

void QueryGate::Leave(Clock::duration took) {
  constexpr double kNewest = 0.2;  // weight of the last turn
  const double took_s = std::chrono::duration<double>(took).count();
  {
    const std::lock_guard lock(mutex_);
    ++free_;
    turn_s_ = turn_s_ > 0 ? (1 - kNewest) * turn_s_ + kNewest * took_s : took_s;
  }
  freed_.notify_one();
}

}  // namespace waystone
