// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace waystone {

using Clock = std::chrono::steady_clock;

inline double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

inline double MillisecondsSince(Clock::time_point start) { return 1000 * SecondsSince(start); }

}  // namespace waystone
