// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/orientation/unknown_corridors.h"

#include <algorithm>

namespace waystone {

std::vector<SequenceId> ListSequencesWithUnknownCorridors(const MapData& map) {
  std::vector<SequenceId> unknown;
  if (!map.orientation) return unknown;
  for (const Sequence& sequence : map.sequences) {
    const bool has_frames = std::ranges::any_of(
        map.orientation->frames,
        [&](const OrientationFrame& frame) { return frame.sequence == sequence.id; });
    if (has_frames && !SeesAllAround(sequence)) unknown.push_back(sequence.id);
  }
  return unknown;
}

}  // namespace waystone
