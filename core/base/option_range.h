// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/base/error.h"

namespace waystone {

// Throws MapError(kBadOptions) unless low <= value <= high (which a NaN is not).
inline void CheckRange(const std::string& name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw MapError(ErrorCode::kBadOptions, name + " is " + std::to_string(value) +
                                             "; it must be between " + std::to_string(low) +
                                             " and " + std::to_string(high));
}

}  // namespace waystone
