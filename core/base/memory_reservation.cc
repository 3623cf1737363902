// SPDX-License-Identifier: Apache-2.0
#include "core/base/memory_reservation.h"

#include <sys/mman.h>

#include <mutex>
#include <new>

namespace waystone {
namespace {

std::mutex reserved_mutex;
int64_t reserved_bytes = 0;  // by all that live

bool HasRoom(int64_t bytes) {
  const auto size = static_cast<size_t>(bytes);
  void* const room =
      mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) return false;
  munmap(room, size);
  return true;
}

}  // namespace

MemoryReservation::MemoryReservation(int64_t bytes) : bytes_(bytes) {
  const std::lock_guard lock(reserved_mutex);
  if (!HasRoom(reserved_bytes + bytes_)) throw std::bad_alloc();
  reserved_bytes += bytes_;
}

MemoryReservation::~MemoryReservation() {
  const std::lock_guard lock(reserved_mutex);
  reserved_bytes -= bytes_;
}

}  // namespace waystone
