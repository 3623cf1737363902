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

// The names of FormatGraph's formats, including those that not every map supports. Thread-safe.
std::vector<std::string> GraphFormatNames();

// A map in a format that other programs read:
//   graphml  planes and their edges with homologies, for Gephi, yEd, networkx
//   dot      the same for Graphviz
//   and those of pose_formats.h, for maps with an appearance layer; MapError(kNotAvailable) with
//   the reason for others
// Throws MapError(kBadRequest) for another name. Deterministic; thread-safe.
GraphText FormatGraph(const MapIndex& index, const std::string& format);

}  // namespace waystone
