// SPDX-License-Identifier: Apache-2.0
#include "server/http/query_gate.h"

#include "core/base/error.h"

namespace waystone {

QueryGate::Turn QueryGate::Enter() {
  std::unique_lock lock(mutex_);
  if (free_ == 0) {
    if (seats_ == 0) {
      throw MapError(ErrorCode::kBusy, "all query threads and their queue are full; try again");
    }
    --seats_;
    freed_.wait(lock, [this] { return free_ > 0; });
    ++seats_;
  }
  --free_;
  return Turn(this);
}

void QueryGate::Leave() {
  {
    const std::lock_guard lock(mutex_);
    ++free_;
  }
  freed_.notify_one();
}

}  // namespace waystone
