// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "schema/map_data.h"

// What of a map the command line names by ids.
namespace waystone {

// "3,5,9:12": ids, and ranges with both their ends, each of which the map has. Throws MapError:
// kUsage for what is no list of ids or a range that ends before it begins, kNotFound for an id that
// the map hasn't got; both say `--` and the kind's name, as the flag is called.
std::vector<NamedRange> RangesOfIds(const MapData& map, NamedKind kind, const std::string& text);

// The keyframes, and the panoramas, in such lists.
std::set<KeyframeId> KeyframesOfIds(const MapData& map, const std::vector<std::string>& texts);
std::set<AppearanceNodeId> NodesOfIds(const MapData& map, const std::vector<std::string>& texts);

// "0,0 4.5,0 4.5,3": corners in order. Throws MapError(kUsage), naming the flag, for anything else.
NamedPolygon ReadPolygon(const std::string& flag, const std::string& text);

// The keyframes and panoramas inside of a polygon, or in the named place of this name. Throws
// MapError: kNoLayer for a polygon on a map without poses and panoramas; kNotFound for a name that
// no place has.
std::set<KeyframeId> KeyframesInPolygon(const MapData& map, const NamedPolygon& polygon);
std::set<AppearanceNodeId> NodesInPolygon(const MapData& map, const NamedPolygon& polygon);
std::set<KeyframeId> KeyframesOfPlace(const MapData& map, const std::string& name);
std::set<AppearanceNodeId> NodesOfPlace(const MapData& map, const std::string& name);

// Those of a session, by its number (from 1, in the order of `waystone info`) or by its name, and
// its sequences. Throws MapError(kNotFound) where there is none, or several have the name.
std::set<KeyframeId> KeyframesOfSession(const MapData& map, const std::string& session);
std::set<AppearanceNodeId> NodesOfSession(const MapData& map, const std::string& session);
std::set<SequenceId> SequencesOfSession(const MapData& map, const std::string& session);

}  // namespace waystone
