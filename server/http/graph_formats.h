// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "localizer/map_index.h"

namespace waystone {

struct GraphText {
  std::string text;
  std::string media_type;
};

// The formats that FormatGraph knows by name, also those that a map of planes can't give.
std::vector<std::string> GraphFormatNames();

// A map in a format that other programs read:
//   graphml  planes and their edges with homologies, for Gephi, yEd, networkx
//   dot      the same for Graphviz
//   g2o, geojson, ply, tum, colmap, poses  need metric poses of keyframes or planes. A map of
//   planes
//            has homographies between images and none, so they throw MapError(kNotAvailable).
// Throws MapError(kBadRequest) for another name. Deterministic; thread-safe.
GraphText FormatGraph(const MapIndex& index, const std::string& format);

}  // namespace waystone
