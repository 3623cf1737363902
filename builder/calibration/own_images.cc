// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/own_images.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

#include "builder/calibration/map_parts.h"
#include "core/base/check.h"
#include "localizer/appearance/appearance.h"
#include "localizer/localizer.h"
#include "localizer/planes/surroundings.h"

namespace waystone {
namespace {

// `is_found` of each number below `count`, several at a time.
template <typename IsFound>
OwnImages CountFound(size_t count, const IsFound& is_found) {
  std::atomic<int> found = 0;
  tbb::parallel_for(size_t{0}, count, [&](size_t i) { found += is_found(i) ? 1 : 0; });
  return {static_cast<int>(count), found};
}

}  // namespace

OwnImages FindOwnKeyframes(const MapData& map, const std::vector<SampledKeyframe>& samples,
                           const LocalizeOptions& options) {
  const auto index = MapIndex::Build(CopyPlanes(map));
  return CountFound(samples.size(), [&](size_t i) {
    const Answer answer = LocalizeFeatures(*index, samples[i].features, options);
    if (answer.verdict != Verdict::kLocalized) return false;
    return KeyframesAreNear(*index, index->IndexOf(answer.planes.keyframe->id),
                            index->IndexOf(samples[i].keyframe));
  });
}

OwnImages FindOwnPanoramas(const MapData& map, const std::vector<AppearanceSampleFrame>& samples,
                           const PanoramaQueryOptions& options) {
  WS_CHECK(map.appearance.has_value(), "the map has no appearance layer");
  const auto index = MapIndex::Build(CopyPanoramas(map));
  std::vector<const AppearanceSampleFrame*> nodes;
  for (const AppearanceSampleFrame& sample : samples) {
    if (sample.node >= 0) nodes.push_back(&sample);
  }
  return CountFound(nodes.size(), [&](size_t i) {
    PanoramaQuery query{nodes[i]->signature, std::nullopt};
    if (nodes[i]->features.size() > 0) query.features = nodes[i]->features;
    const Answer answer = LocalizeDescribed(*index, query, options);
    if (answer.verdict != Verdict::kLocalized) return false;
    const std::vector<AppearanceNode>& all = map.appearance->nodes;
    const auto found =
        std::ranges::lower_bound(all, answer.panorama->node.id, {}, &AppearanceNode::id);
    const AppearanceNode& own = all[nodes[i]->node];
    return found->id == own.id || found->signature == own.signature;  // in maps of several sessions
  });
}

}  // namespace waystone
