// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include "schema/layers/layer_problems.h"

namespace waystone {

void FindLinkProblems(const MapData& map, std::vector<MapProblem>& problems) {
  const auto has = [&map](KeyframeId id) {
    return std::ranges::binary_search(map.keyframes, id, {}, &Keyframe::id);
  };
  KeyframeLink last;
  for (const KeyframeLink& link : map.links) {
    const std::string where =
        "keyframe_links " + std::to_string(link.a.value) + "/" + std::to_string(link.b.value);
    if (!(link.a < link.b)) problems.push_back({where, "a must be below b"});
    if (!(last < link)) problems.push_back({where, "links must be unique and sorted by (a, b)"});
    for (const KeyframeId id : {link.a, link.b}) {
      if (!has(id)) problems.push_back({where, "there is no keyframe " + std::to_string(id.value)});
    }
    last = link;
  }
}

}  // namespace waystone
