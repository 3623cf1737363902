// SPDX-License-Identifier: Apache-2.0
#include "core/base/check.h"

namespace waystone {

void FailCheck(const char* file, int line, const char* condition, const std::string& message) {
  throw CheckFailure(std::string(file) + ":" + std::to_string(line) + ": " + condition +
                     " does not hold: " + message);
}

}  // namespace waystone
