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
  int features = 0;  // that went
  int left = 0;      // 0: the plane went, because too few were left
};

// A session that didn't find what went.
struct MissingSession {
  std::string name;
  int plane_features = 0;
  int landmarks = 0;
};

// What pruning did.
struct PruneReport {
  int looked_for = 0;      // features of the map that a session looked for
  int plane_features = 0;  // that went; those of planes that went are among them
  int landmarks = 0;       // that went
  int edges = 0;           // that went with their planes
  std::vector<PrunedPlane> planes;
  std::vector<MissingSession> sessions;  // in the map's order
  std::vector<std::string> names;        // of places of which nothing is left

  bool changed() const { return plane_features > 0 || landmarks > 0; }
};

struct PruneResult {
  MapData map;
  PruneReport report;
};

// The map without what later walks looked for and didn't find. A feature goes where at least
// `min_looks` of their images should have shown it since a walk showed it last and none did, and
// where what lies around it wasn't found either: a single feature may just be hard to find again,
// while a poster that is gone takes all of its features with it. Planes that are left with too few
// features go, with their edges; keyframes stay, as do all ids and the history. The index is made
// anew, and the verdict calibrated by what the map holds; a map that loses nothing is the same.
// Deterministic. Throws MapError: kBadRequest where no walk looked for anything; kBadOptions.
PruneResult PruneMap(MapData map, int min_looks, const BuildOptions& options);

}  // namespace waystone
