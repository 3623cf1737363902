// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "builder/joining/recognise_keyframes.h"
#include "builder/joining/recognise_nodes.h"
#include "schema/map_data.h"

namespace waystone {

// Keyframes and panoramas of one map (`asking`) that were localized in another (`asked`); both are
// indices in the list of maps.
struct Recognition {
  size_t asked = 0;
  size_t asking = 0;
  std::vector<RecognisedKeyframe> keyframes;
  std::vector<RecognisedNode> nodes = {};
};

// Expresses the pose layers of all maps that have one, the areas of their named places and the
// appearance layers that are in their frames in the frame of one of them: with `keep_first` of the
// first that has one, and else of the first whose unit is metres, where there is one. Two frames
// are aligned by the keyframes and panoramas of either map that were localized with a pose in the
// other, and by way of a third map where these don't suffice. Answers in changed frames are
// converted too. Deterministic; thread-safe for different maps. Throws MapError(kBadRequest) for a
// map that can't be aligned. Returns which map's frame it is; nothing where no map has poses.
std::optional<size_t> JoinFrames(std::vector<Recognition>& recognitions, bool keep_first,
                                 std::vector<MapData>& maps);

}  // namespace waystone
