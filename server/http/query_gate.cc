// SPDX-License-Identifier: Apache-2.0
#include "server/http/query_gate.h"

#include "core/base/check.h"
#include "core/base/error.h"

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
      throw MapError(ErrorCode::kBusy, "all query threads and their queue are full; try again");
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

void QueryGate::Leave() {
  {
    const std::lock_guard lock(mutex_);
    ++free_;
  }
  freed_.notify_one();
}

}  // namespace waystone
