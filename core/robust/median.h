// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace waystone {

// The middle one of the values in ascending order; for an even number of values the upper of the
// two middle ones, so that it is always one of them. 0 for no values. None may be NaN. Pure;
// thread-safe.
template <class T>
T Median(std::vector<T> values) {
  if (values.empty()) return T{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median of the length of an error whose two coordinates are normal with unit standard deviation,
// sqrt(2 ln 2): an observed median divided by this is a sigma that outliers hardly change.
inline constexpr double kRayleighMedian = 1.1774;

}  // namespace waystone
