// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace waystone {

// The nearest neighbours of every point of a set, nearest first. Immutable after construction: any
// number of threads may query it.
class Neighbourhoods {
 public:
  // `k` neighbours per point (fewer when there are fewer points). Cost: quadratic in the number of
  // points.
  Neighbourhoods(std::span<const Eigen::Vector2d> points, int k);

  std::span<const int> of(int point) const {
    return {neighbours_.data() + static_cast<size_t>(point) * k_, static_cast<size_t>(k_)};
  }

 private:
  int k_ = 0;
  std::vector<int> neighbours_;
};

}  // namespace waystone
