// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace waystone {

// Checks that there is memory for a library that ends the program when an allocation fails: throws
// std::bad_alloc unless the address space has room for this and all other living reservations. It
// allocates nothing, so large allocations without a reservation may still take the room meanwhile.
// Costs some microseconds. Thread-safe.
class MemoryReservation {
 public:
  explicit MemoryReservation(int64_t bytes);
  ~MemoryReservation();
  MemoryReservation(const MemoryReservation&) = delete;
  MemoryReservation& operator=(const MemoryReservation&) = delete;

 private:
  int64_t bytes_;
};

}  // namespace waystone
