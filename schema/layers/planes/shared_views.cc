// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/planes/shared_views.h"

namespace waystone {

std::vector<SharedView> SharedViews(const Plane& m, const Plane& n) {
  constexpr size_t kMost = 20;
  std::vector<SharedView> shared;
  auto of_n = n.views.begin();
  for (const PlaneView& of_m : m.views) {  // both are sorted by keyframe
    while (of_n != n.views.end() && of_n->keyframe < of_m.keyframe) ++of_n;
    if (of_n == n.views.end()) break;
    if (of_n->keyframe == of_m.keyframe) shared.push_back({&of_m, &*of_n});
  }
  if (shared.size() <= kMost) return shared;
  std::vector<SharedView> spread;
  for (size_t i = 0; i < kMost; ++i)
    spread.push_back(shared[i * (shared.size() - 1) / (kMost - 1)]);
  return spread;
}

}  // namespace waystone
