// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <optional>
#include <string>

namespace waystone {

constexpr bool CanLimitAddressSpace() {
#ifdef WAYSTONE_SANITIZED
  return false;
#else
  return true;
#endif
}

// Leaves a process this much more than it has; all there is without an amount. Whether it could.
inline bool LimitAddressSpace(pid_t process, std::optional<rlim_t> spare_bytes) {
  std::ifstream sizes("/proc/" + std::to_string(process) + "/statm");
  rlim_t pages = 0;
  sizes >> pages;
  const rlimit limit{
      spare_bytes ? pages * static_cast<rlim_t>(getpagesize()) + *spare_bytes : RLIM_INFINITY,
      RLIM_INFINITY};
  return prlimit(process, RLIMIT_AS, &limit, nullptr) == 0;
}

}  // namespace waystone
