// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/build_options.h"
#include "builder/planes/keyframe_sample.h"
#include "schema/map_data.h"

namespace waystone {

// What joining maps did.
struct JoinReport {
  int planes_fused = 0;     // of different maps, by eq. (6)
  int surfaces_joined = 0;  // pairs of planes of different maps that an edge joins as one surface
  int sessions = 0;         // of the joined map
  // Keyframes of one map that were localized in another, and are linked with the nearest one there.
  int keyframes_recognised = 0;
  int panoramas_recognised = 0;  // of one map, localized in another
  int loops = 0;                 // between panoramas of different maps that fit all others
  int orientation_loops = 0;     // between nodes of different maps' orientation layers
  int sequences_turned = 0;      // by quarter turns into another map's building axes
  // Features of the map that an added walk should have shown, and those that it did.
  int features_looked_for = 0;
  int features_found = 0;
  std::vector<std::string> floor_plans;  // left out: of maps whose frame wasn't kept, by name
};

struct JoinResult {
  MapData map;
  JoinReport report;
};

// One map of several that were built apart, as if the sequences of all had been built together:
// keyframes of each are localized in the others (RecogniseKeyframes), planes that were seen in
// several of them are fused by eq. (6) or joined by an edge, panoramas are connected by loops and
// orientation layers by matching nodes, and the verdicts are recalibrated by what the maps hold.
// Maps that have nothing in common stay separate: the joined map has several parts. Each map
// becomes a session of the joined one, or as many sessions as it has itself. Only the floor plans
// of the map whose frame is kept remain. The result doesn't depend on the order of `maps`: they are
// ordered by their versions (MapInfo::version), and ids continue from one map to the next.
// `options` say how planes are fused and the verdict calibrated; the features' type is the maps'.
// Deterministic, on any number of threads. Throws MapError(kBadRequest) for fewer than two maps,
// maps of different feature types, a session that is in several of them or whose pictures are all
// in another map, and layers that can't be joined (CheckLayersAreJoinable, JoinFrames,
// JoinAppearance); kMapDamaged for ids that can't be counted on; kBadOptions.
JoinResult MergeMaps(std::vector<MapData> maps, const std::string& name,
                     const BuildOptions& options);

// The same of a map and another one, which was built for it and becomes its last session or
// sessions: what `map` holds keeps its ids, its name and the record of its options. Only keyframes
// of `added` are localized in `map`, so that the cost doesn't grow with the keyframes of `map`.
// `images` are those of `added` whose features are available: LookAgain looks in them for features
// of `map`, for PruneMap.
JoinResult AddToMap(MapData map, MapData added, const BuildOptions& options,
                    const std::vector<WalkImage>& images = {});

}  // namespace waystone
