// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>

namespace waystone {

constexpr bool CanLimitAddressSpace() {
#ifdef WAYSTONE_SANITIZED
  return false;
#else
  return true;
#endif
}

// Leaves this process this much more than it has.
inline void LimitAddressSpace(int64_t spare_bytes) {
  std::ifstream sizes("/proc/self/statm");
  rlim_t pages = 0;
  sizes >> pages;
  const rlimit limit{pages * static_cast<rlim_t>(getpagesize()) + static_cast<rlim_t>(spare_bytes),
                     RLIM_INFINITY};
  setrlimit(RLIMIT_AS, &limit);
}

}  // namespace waystone
