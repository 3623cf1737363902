// SPDX-License-Identifier: Apache-2.0
#include "core/homography/neighbourhoods.h"

#include <algorithm>
#include <utility>

namespace waystone {

Neighbourhoods::Neighbourhoods(std::span<const Eigen::Vector2d> points, int k)
    : k_(std::max(0, std::min<int>(k, static_cast<int>(points.size()) - 1))) {
  const int n = static_cast<int>(points.size());
  neighbours_.resize(static_cast<size_t>(n) * k_);
  if (k_ == 0) return;
  std::vector<std::pair<double, int>> others(n - 1);
  for (int i = 0; i < n; ++i) {
    int count = 0;
    for (int j = 0; j < n; ++j) {
      if (j != i) others[count++] = {(points[j] - points[i]).squaredNorm(), j};
    }
    std::nth_element(others.begin(), others.begin() + (k_ - 1), others.end());
    std::sort(others.begin(), others.begin() + k_);
    for (int m = 0; m < k_; ++m) neighbours_[static_cast<size_t>(i) * k_ + m] = others[m].second;
  }
}

}  // namespace waystone
