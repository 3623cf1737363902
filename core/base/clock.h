// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace waystone {

using Clock = std::chrono::steady_clock;

inline double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

inline double MillisecondsSince(Clock::time_point start) { return 1000 * SecondsSince(start); }

// Milliseconds since construction or the last Lap(), for timing consecutive stages. Not
// thread-safe.
class LapTimer {
 public:
  double Lap() {
    const Clock::time_point now = Clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  Clock::time_point last_ = Clock::now();
};

}  // namespace waystone
