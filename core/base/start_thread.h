// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <system_error>
#include <thread>
#include <utility>

namespace waystone {

// For StartThread.
[[noreturn]] void ThrowNoThread(const std::error_code& cause);

// Starts a thread. Throws MapError(kOutOfMemory) where the system can't: there is no memory for its
// stack, or a limit on threads is reached (the user's, a container's), which systems don't tell
// apart. Thread-safe.
template <class... Arguments>
std::thread StartThread(Arguments&&... arguments) {
  try {
    return std::thread(std::forward<Arguments>(arguments)...);
  } catch (const std::system_error& error) {
    ThrowNoThread(error.code());
  }
}

}  // namespace waystone
