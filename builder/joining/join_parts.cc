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

// Of keyframes and panoramas.
std::vector<Picture> PicturesOf(const MapData& map) {
  std::vector<Picture> pictures;
  for (const Keyframe& keyframe : map.keyframes) pictures.push_back(keyframe.picture);
  if (!map.appearance) return pictures;
  for (const AppearanceNode& node : map.appearance->nodes) pictures.push_back(node.picture);
  return pictures;
}

bool ShowsNothingElse(const MapData& part, const MapData& neighbour) {
  const std::vector<Picture> pictures = PicturesOf(part);
  if (pictures.empty()) return !part.orientation;
  const std::vector<Picture> others = PicturesOf(neighbour);
  const std::set<Picture> known(others.begin(), others.end());
  return std::ranges::all_of(pictures, [&](const Picture& picture) {
    return !picture.empty() && known.contains(picture);
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
