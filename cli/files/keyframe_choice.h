// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>

#include "schema/map_data.h"

// Keyframes of a map as the command line names them.
namespace waystone {

// Those of a session, by its number (from 1, in the order of `waystone info`) or by its name.
// Throws MapError(kNotFound) where there is none, or several have the name.
std::set<KeyframeId> KeyframesOfSession(const MapData& map, const std::string& session);

// "3,7,10-20": single ids must be in the map, ranges take the keyframes that the map has of them.
// Throws MapError: kUsage for what is no list of ids, kNotFound for an id or a range without a
// keyframe.
std::set<KeyframeId> KeyframesInRanges(const MapData& map, const std::string& ranges);

}  // namespace waystone
