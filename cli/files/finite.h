// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <optional>
#include <string>

#include "core/base/text.h"

namespace waystone {

// For an option's value: refuses NaN, which passes every range of CLI11, and infinity.
inline CLI::Validator Finite() {
  const auto check = [](const std::string& text) {
    const auto number = ToNumber(text);
    return number && !std::isfinite(*number) ? "Value " + text + " not a finite number"
                                             : std::string();
  };
  return {check, "", "FINITE"};
}

}  // namespace waystone
