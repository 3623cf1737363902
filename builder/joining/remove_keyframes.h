// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/build_options.h"
#include "builder/joining/remove_layers.h"
#include "schema/map_data.h"

namespace waystone {

// What a removal did.
struct RemoveReport {
  int keyframes = 0;                     // removed
  int panoramas = 0;                     // removed
  int orientation_frames = 0;            // removed
  int planes = 0;                        // removed: no view of them is left, or too few features
  int planes_anchored = 0;               // that have another reference image now
  int edges = 0;                         // removed
  int sequences = 0;                     // removed: no keyframe of them is left
  std::vector<std::string> names;        // of places of which nothing is left
  std::vector<std::string> floor_plans;  // by name, removed: no keyframe with a pose is left
};

struct RemoveResult {
  MapData map;
  RemoveReport report;
};

// The map without these keyframes and panoramas and without what only they showed. Planes lose
// their views; one whose reference image goes is expressed in the first that is left. Features stay
// where a keyframe that is left could see them: a map doesn't say which keyframe each was found in.
// Edges keep their homology where its two keyframes are left, and get that of two others that saw
// both planes otherwise. Frames of the orientation layer go as FramesThatGo says. Sequences without
// a keyframe, panorama or orientation frame go, with their sessions. All that stays keeps its id.
// The index is made anew and the verdicts of layers that lost something are calibrated by what the
// map holds. Deterministic. Throws MapError: kNotFound for what isn't in the map; kBadRequest where
// nothing would be left; kBadOptions.
RemoveResult RemoveFromMap(MapData map, const Removal& removed, const BuildOptions& options);

}  // namespace waystone
