// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/shortlist.h"

#include <algorithm>

namespace waystone {

std::vector<ShortlistedPlane> ShortlistPlanes(const MapIndex& index, const Features& query,
                                              const PlaneQueryOptions& options) {
  const int k = options.votes_per_feature;
  const std::vector<Neighbour> nearest =
      index.search().Nearest(query.descriptors, k, options.probes);
  std::vector<ShortlistedPlane> planes(index.map().planes.size());
  for (int p = 0; p < static_cast<int>(planes.size()); ++p) planes[p].plane = p;
  std::vector<int> last_voter(planes.size(), -1);
  for (int q = 0; q < query.size(); ++q) {
    for (int i = 0; i < k; ++i) {
      const int row = nearest[static_cast<size_t>(q) * k + i].row;
      if (row < 0) continue;
      const int plane = index.PlaneOfRow(row);
      if (last_voter[plane] == q) continue;
      last_voter[plane] = q;
      ++planes[plane].votes;
    }
  }
  std::erase_if(planes, [&](const auto& plane) { return plane.votes < options.min_votes; });
  std::stable_sort(planes.begin(), planes.end(),
                   [](const auto& a, const auto& b) { return a.votes > b.votes; });
  if (static_cast<int>(planes.size()) > options.max_candidates) {
    planes.resize(options.max_candidates);
  }
  return planes;
}

}  // namespace waystone
