// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/join_parts.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>

namespace waystone {
namespace {

using Picture = std::vector<uint8_t>;

bool ShowsNothingElse(const MapData& part, const MapData& neighbour) {
  std::set<Picture> known;
  for (const Keyframe& keyframe : neighbour.keyframes) known.insert(keyframe.jpeg);
  return std::ranges::all_of(part.keyframes, [&](const Keyframe& keyframe) {
    return !keyframe.jpeg.empty() && known.contains(keyframe.jpeg);
  });
}

void LeaveOutKnownParts(std::vector<MapData>& parts) {
  for (size_t i = 0; i < parts.size() && parts.size() > 1;) {
    const bool known = (i > 0 && ShowsNothingElse(parts[i], parts[i - 1])) ||
                       (i + 1 < parts.size() && ShowsNothingElse(parts[i], parts[i + 1]));
    if (known) {
      parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

}  // namespace

JoinResult JoinParts(std::vector<MapData> parts, const std::string& name,
                     const BuildOptions& options) {
  LeaveOutKnownParts(parts);
  if (parts.size() != 1) return MergeMaps(std::move(parts), name, options);
  JoinResult result;
  result.map = std::move(parts.front());
  result.map.info.name = name;
  result.report.sessions = 1;
  return result;
}

}  // namespace waystone
