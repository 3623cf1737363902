// SPDX-License-Identifier: Apache-2.0
#include "core/base/memory_reservation.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "tests/core/base/address_space.h"

namespace waystone {
namespace {

bool HasRoomFor(int64_t bytes) {
  try {
    const MemoryReservation room(bytes);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

// Ends the process: 0 where all is as it should be.
[[noreturn]] void ReserveWithin100MB() {
  bool right = LimitAddressSpace(getpid(), 100'000'000) && HasRoomFor(80'000'000) &&
               !HasRoomFor(120'000'000) && HasRoomFor(80'000'000);
  {
    const MemoryReservation room(60'000'000);
    right = right && !HasRoomFor(60'000'000) && HasRoomFor(20'000'000);
  }
  right = right && HasRoomFor(60'000'000);
  std::_Exit(right ? 0 : 1);
}

TEST(MemoryReservationTest, CountsThoseThatLive) {
  if (!CanLimitAddressSpace()) GTEST_SKIP() << "sanitizers take the address space for themselves";
  EXPECT_EXIT(ReserveWithin100MB(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace waystone
