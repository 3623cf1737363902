// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace waystone {

// The smallest value that at least `share` (0 to 1) of the values don't exceed: the nearest rank,
// always one of the values. 0 for no values. None may be NaN. Pure; thread-safe.
inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(count)));
  const auto at = values.begin() + std::clamp<std::ptrdiff_t>(rank - 1, 0, count - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace waystone
