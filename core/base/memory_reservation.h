// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace waystone {

// Room for what a library is about to allocate that ends the program when it can't: throws
// std::bad_alloc unless the address space has room for this and all other reservations that live.
// Takes none of it, and so can't keep others from it: whoever allocates much without a reservation
// meanwhile may take it. Costs some microseconds. Thread-safe.
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
