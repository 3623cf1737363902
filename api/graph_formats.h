// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "localizer/index/map_index.h"

namespace waystone {

struct GraphText {
  std::string text;
  std::string media_type;
};

// The formats that FormatGraph knows by name, also those that not every map can give.
std::vector<std::string> GraphFormatNames();

// A map in a format that other programs read:
//   graphml  planes and their edges with homologies, for Gephi, yEd, networkx
//   dot      the same for Graphviz
//   and those of pose_formats.h, for maps with an appearance layer; MapError(kNotAvailable) with
//   the reason for others
// Throws MapError(kBadRequest) for another name. Deterministic; thread-safe.
GraphText FormatGraph(const MapIndex& index, const std::string& format);

}  // namespace waystone
