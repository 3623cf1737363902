// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/misclassification.h"

#include <algorithm>

#include "core/base/check.h"

namespace waystone::bench {

double Misclassification(const std::vector<int>& truth, const std::vector<int>& found) {
  WS_CHECK(truth.size() == found.size(), "labels of different lengths");
  if (truth.empty()) return 0;
  const int true_planes = *std::max_element(truth.begin(), truth.end());
  const int found_planes = *std::max_element(found.begin(), found.end());
  WS_CHECK(true_planes <= 20, "at most 20 true planes");
  std::vector<std::vector<int>> both(found_planes + 1, std::vector<int>(true_planes + 1, 0));
  for (size_t row = 0; row < truth.size(); ++row) ++both[found[row]][truth[row]];
  // best[used]: most rows that are right when the found planes so far took the true ones in `used`.
  std::vector<int> best(size_t{1} << true_planes, 0);
  for (int f = 1; f <= found_planes; ++f) {
    std::vector<int> next = best;
    for (size_t used = 0; used < best.size(); ++used) {
      for (int t = 0; t < true_planes; ++t) {
        const size_t bit = size_t{1} << t;
        if ((used & bit) == 0)
          next[used | bit] = std::max(next[used | bit], best[used] + both[f][t + 1]);
      }
    }
    best = std::move(next);
  }
  const int right = both[0][0] + *std::max_element(best.begin(), best.end());
  return 1 - static_cast<double>(right) / truth.size();
}

}  // namespace waystone::bench
