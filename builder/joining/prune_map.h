// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/build_options.h"
#include "schema/map_data.h"

namespace waystone {

// A plane that lost features.
struct PrunedPlane {
  PlaneId id;
  KeyframeId reference;
  int features = 0;  // removed
  int left = 0;      // 0: the plane was removed, because too few were left
};

// A session that didn't find removed features.
struct MissingSession {
  std::string name;
  int plane_features = 0;
  int landmarks = 0;
};

// What pruning did.
struct PruneReport {
  int looked_for = 0;      // features of the map that a session looked for
  int plane_features = 0;  // removed, including those of removed planes
  int landmarks = 0;       // removed
  int edges = 0;           // removed with their planes
  std::vector<PrunedPlane> planes;
  std::vector<MissingSession> sessions;  // in the map's order
  std::vector<std::string> names;        // of places of which nothing is left

  bool changed() const { return plane_features > 0 || landmarks > 0; }
};

struct PruneResult {
  MapData map;
  PruneReport report;
};

// The map without features that later walks looked for and didn't find. A feature is removed where
// at least `min_looks` of their images should have shown it since a walk last found it and none
// did, and where the features around it weren't found either: a single feature may just be hard to
// find again, while a poster that is gone takes all of its features with it. Planes with too few
// features left are removed, with their edges; keyframes, all ids and the history stay. The index
// is rebuilt, and the verdict calibrated by what the map holds; a map that loses nothing is
// unchanged. Deterministic, on any number of threads. Throws MapError: kBadRequest where no walk
// looked for anything; kBadOptions.
PruneResult PruneMap(MapData map, int min_looks, const BuildOptions& options);

}  // namespace waystone
