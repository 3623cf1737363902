// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace waystone {

// A programmer's error: a broken contract inside Waystone. It is thrown, not aborted on, so that a
// server survives it; only a top level (a program's main, a request's handler) catches it. Any
// thread may throw it.
class CheckFailure : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

// Throws CheckFailure naming the place and the condition.
[[noreturn]] void FailCheck(const char* file, int line, const char* condition,
                            const std::string& message);

}  // namespace waystone

// Throws CheckFailure unless `condition` holds. `message` says what was wrong with which value.
#define WS_CHECK(condition, message)                                    \
  do {                                                                  \
    if (!(condition)) {                                                 \
      ::waystone::FailCheck(__FILE__, __LINE__, #condition, (message)); \
    }                                                                   \
  } while (false)
