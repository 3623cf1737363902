// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/remove_layers.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>

namespace waystone {
namespace {

// Whether each image of a sequence that is a keyframe or panorama goes, by its frame.
using Fates = std::map<SequenceId, std::map<int, bool>>;

Fates FatesOf(const MapData& map, const Removal& removed) {
  Fates fates;
  const auto add = [&fates](SequenceId sequence, int frame, bool goes) {
    const auto [known, is_new] = fates[sequence].emplace(frame, goes);
    if (!is_new) known->second = known->second && goes;
  };
  for (const Keyframe& row : map.keyframes) {
    add(row.sequence, row.frame, removed.keyframes.contains(row.id));
  }
  if (!map.appearance) return fates;
  for (const AppearanceNode& row : map.appearance->nodes) {
    add(row.sequence, row.frame, removed.nodes.contains(row.id));
  }
  return fates;
}

// The fate of the nearest one; if two are equally near, one that stays decides.
bool GoesWithNearest(const std::map<int, bool>& fates, int frame) {
  const auto after = fates.lower_bound(frame);
  if (after == fates.begin()) return after->second;
  const auto before = std::prev(after);
  if (after == fates.end()) return before->second;
  const int64_t to_after = int64_t{after->first} - frame;
  const int64_t to_before = int64_t{frame} - before->first;
  if (to_after == to_before) return after->second && before->second;
  return to_after < to_before ? after->second : before->second;
}

// The part of a corridor that is left.
std::optional<Corridor> Left(const Corridor& corridor, const std::vector<OrientationFrame>& left) {
  const auto first = std::ranges::lower_bound(left, corridor.first, {}, &OrientationFrame::id);
  const auto end = std::ranges::upper_bound(left, corridor.last, {}, &OrientationFrame::id);
  if (first == end) return std::nullopt;
  return Corridor{first->id, std::prev(end)->id, corridor.axis};
}

}  // namespace

std::set<OrientationFrameId> FramesThatGo(const MapData& map, const Removal& removed) {
  std::set<OrientationFrameId> going;
  if (!map.orientation) return going;
  const Fates fates = FatesOf(map, removed);
  for (const OrientationFrame& frame : map.orientation->frames) {
    const auto of_sequence = fates.find(frame.sequence);
    const bool goes =
        removed.sequences.contains(frame.sequence) ||
        (of_sequence != fates.end() && GoesWithNearest(of_sequence->second, frame.frame));
    if (goes) going.insert(frame.id);
  }
  return going;
}

void RemoveNodes(const std::set<AppearanceNodeId>& removed, MapData& map) {
  if (!map.appearance || removed.empty()) return;
  AppearanceLayer& layer = *map.appearance;
  std::erase_if(layer.nodes, [&](const auto& row) { return removed.contains(row.id); });
  std::erase_if(layer.edges, [&](const auto& row) {
    return removed.contains(row.a) || removed.contains(row.b);
  });
  if (map.poses) {
    std::erase_if(map.poses->nodes, [&](const auto& row) { return removed.contains(row.node); });
  }
  if (layer.nodes.empty()) map.appearance.reset();
}

void RemoveFrames(const std::set<OrientationFrameId>& removed, MapData& map) {
  if (!map.orientation || removed.empty()) return;
  OrientationLayer& layer = *map.orientation;
  std::erase_if(layer.frames, [&](const auto& row) { return removed.contains(row.id); });
  std::erase_if(layer.turns, [&](const auto& row) { return removed.contains(row.frame); });
  std::erase_if(layer.nodes, [&](const auto& row) { return removed.contains(row.frame); });
  std::erase_if(layer.edges, [&](const auto& row) {
    return removed.contains(row.a) || removed.contains(row.b);
  });
  std::vector<Corridor> corridors;
  for (const Corridor& corridor : layer.corridors) {
    if (const auto left = Left(corridor, layer.frames)) corridors.push_back(*left);
  }
  layer.corridors = std::move(corridors);
  if (layer.frames.empty()) map.orientation.reset();
}

}  // namespace waystone
