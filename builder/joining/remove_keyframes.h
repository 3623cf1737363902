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
  int planes_anchored = 0;               // that have a new reference image
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
// their views; one whose reference image is removed is expressed in its first remaining one.
// Features stay where a remaining keyframe could see them: a map doesn't record in which keyframe
// each was found. Edges keep their homology where its two keyframes remain, and otherwise get that
// of two others that saw both planes. Frames of the orientation layer are removed as FramesThatGo
// says. Sequences without a keyframe, panorama or orientation frame are removed, with their
// sessions. Everything that stays keeps its id. The index is rebuilt and the verdicts of layers
// that lost something are calibrated by what the map holds. Deterministic, on any number of
// threads. Throws MapError: kNotFound for what isn't in the map; kBadRequest where nothing would be
// left; kBadOptions.
RemoveResult RemoveFromMap(MapData map, const Removal& removed, const BuildOptions& options);

}  // namespace waystone
