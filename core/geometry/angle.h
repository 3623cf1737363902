// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace waystone {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kQuarterTurn_rad = kPi / 2;
inline constexpr double kDegreesPerRadian = 180 / kPi;
inline constexpr double kDegree = kPi / 180;  // in radians: 5 * kDegree

}  // namespace waystone
