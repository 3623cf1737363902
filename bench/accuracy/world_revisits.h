// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <vector>

#include "schema/map_data.h"

namespace waystone::bench {

// Surfaces that a walk sees again. A visit of a true plane is a run of consecutive keyframes of
// which each two neighbours carry it: they share `carried` matches on it that its true homography
// confirms. Two visits of one plane are a revisit if some keyframe of one shares as many with some
// keyframe of the other; the others could not be recognised (too_few_matches). Nothing of this
// depends on the map. The map joins a revisit if one of its planes was seen in both visits, or if
// two of its planes, one from each visit, are parts of one surface or have another edge.
struct RevisitFigures {
  int pairs = 0;  // of visits of one true plane: too_few_matches + seen_again
  int too_few_matches = 0;
  int seen_again = 0;  // one_plane + one_surface + joined_by_edge + no_plane + apart
  int one_plane = 0;
  int one_surface = 0;
  int joined_by_edge = 0;
  int no_plane = 0;  // not joined: the map has no plane there in one of the two visits
  int apart = 0;     // not joined, although it has
};

// shared[b][a], a < b: the true planes on which keyframes a and b (indices in map.keyframes) share
// enough matches. `owners`: the true plane of each plane of the map that shows one; the others join
// nothing.
using SharedPlanes = std::vector<std::vector<std::set<int>>>;
RevisitFigures CountRevisits(const SharedPlanes& shared, const MapData& map,
                             const std::map<PlaneId, int>& owners);

}  // namespace waystone::bench
