// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/epoll.h>

#include <array>
#include <cstdint>
#include <span>

#include "server/http/file_descriptor.h"

namespace waystone {

// Waits for events of many descriptors (epoll), or until another thread wakes it up. Inside
// server/http only.
class Poller {
 public:
  Poller();  // throws MapError(kInternal) when there is no descriptor left

  // Waits for `wanted` (EPOLLIN, EPOLLOUT; 0 for nothing) of `fd`, which was waited for with
  // `watched` until now. Its events carry `id`, which isn't 0.
  void Watch(int fd, uint64_t id, uint32_t watched, uint32_t wanted) const;

  // The next events, none after `timeout_ms` or when woken up. Valid until the next call.
  std::span<const epoll_event> Wait(int timeout_ms);

  // Ends a Wait, the next one when there is none. Thread-safe.
  void WakeUp() const;

 private:
  FileDescriptor epoll_;
  FileDescriptor wake_up_;
  std::array<epoll_event, 64> events_{};
};

}  // namespace waystone
