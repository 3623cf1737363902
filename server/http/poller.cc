// SPDX-License-Identifier: Apache-2.0
#include "server/http/poller.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr uint64_t kWakeUp = 0;  // the id of the descriptor that ends a Wait

bool Control(int epoll, int operation, int fd, uint32_t events, uint64_t id) {
  epoll_event event{};
  event.events = events;
  event.data.u64 = id;
  return epoll_ctl(epoll, operation, fd, &event) == 0;
}

}  // namespace

Poller::Poller()
    : epoll_(epoll_create1(EPOLL_CLOEXEC)), wake_up_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!epoll_.is_open() || !wake_up_.is_open()) {
    throw MapError(ErrorCode::kInternal, "no file descriptor is left for the server");
  }
  if (!Control(epoll_.get(), EPOLL_CTL_ADD, wake_up_.get(), EPOLLIN, kWakeUp)) {
    throw MapError(ErrorCode::kInternal, "the kernel watches no more file descriptors (epoll)");
  }
}

bool Poller::Watch(int fd, uint64_t id, uint32_t watched, uint32_t wanted) const {
  if (wanted == watched) return true;
  const int operation =
      wanted == 0 ? EPOLL_CTL_DEL : (watched == 0 ? EPOLL_CTL_ADD : EPOLL_CTL_MOD);
  return Control(epoll_.get(), operation, fd, wanted, id);
}

std::span<const epoll_event> Poller::Wait(int timeout_ms) {
  const int count = epoll_wait(epoll_.get(), events_.data(), events_.size(), timeout_ms);
  const auto begin = events_.begin();
  const auto end = begin + std::max(count, 0);
  const auto woken = std::partition(
      begin, end, [](const epoll_event& event) { return event.data.u64 != kWakeUp; });
  if (woken != end) {
    uint64_t times = 0;
    [[maybe_unused]] const ssize_t size = read(wake_up_.get(), &times, sizeof(times));
  }
  return {begin, woken};
}

void Poller::WakeUp() const {
  const uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(wake_up_.get(), &one, sizeof(one));
}

}  // namespace waystone
