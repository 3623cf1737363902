// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/epoll.h>

#include <array>
#include <cstdint>
#include <span>

#include "server/http/file_descriptor.h"

namespace waystone {

// Waits for events on many descriptors (epoll), or until another thread wakes it up. Internal to
// server/http. Only WakeUp is thread-safe.
class Poller {
 public:
  Poller();  // throws MapError(kInternal) when no descriptor is left or none can be watched

  // Changes the awaited events of `fd` from `watched` to `wanted` (EPOLLIN, EPOLLOUT; 0 for none).
  // Its events carry `id`, which isn't 0. Returns false, and changes nothing, where the kernel has
  // no room for another descriptor.
  [[nodiscard]] bool Watch(int fd, uint64_t id, uint32_t watched, uint32_t wanted) const;

  // The next events; there may be none after `timeout_ms` or a wake-up. Valid until the next call.
  std::span<const epoll_event> Wait(int timeout_ms);

  // Ends the current Wait, or else the next one. Thread-safe.
  void WakeUp() const;

 private:
  FileDescriptor epoll_;
  FileDescriptor wake_up_;
  std::array<epoll_event, 64> events_{};
};

}  // namespace waystone
