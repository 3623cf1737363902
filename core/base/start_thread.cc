// SPDX-License-Identifier: Apache-2.0
#include "core/base/start_thread.h"

#include "core/base/error.h"

namespace waystone {

void ThrowNoThread(const std::error_code& cause) {
  throw MapError(ErrorCode::kOutOfMemory,
                 "cannot start a thread (" + cause.message() +
                     "); raise the limit on threads (ulimit -u, TasksMax) or free memory");
}

}  // namespace waystone
