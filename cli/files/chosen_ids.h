// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "schema/map_data.h"

// The parts of a map that the command line names by ids.
namespace waystone {

// Parses "3,5,9:12": ids, and ranges that include both ends; the map must have each of these.
// Throws MapError: kUsage for anything else, and for a range that ends before it begins; kNotFound
// for an id that the map doesn't have. The former names the flag: `--` and the kind's name.
std::vector<NamedRange> RangesOfIds(const MapData& map, NamedKind kind, const std::string& text);

// The keyframes, or the panoramas, in such lists.
std::set<KeyframeId> KeyframesOfIds(const MapData& map, const std::vector<std::string>& texts);
std::set<AppearanceNodeId> NodesOfIds(const MapData& map, const std::vector<std::string>& texts);

// "0,0 4.5,0 4.5,3": corners in order. Throws MapError(kUsage), naming the flag, for anything else.
NamedPolygon ReadPolygon(const std::string& flag, const std::string& text);

// The keyframes, or the panoramas, inside a polygon or in the named place of this name. Throws
// MapError: kNoLayer for a polygon on a map without poses and panoramas; kNotFound for a name that
// no place has.
std::set<KeyframeId> KeyframesInPolygon(const MapData& map, const NamedPolygon& polygon);
std::set<AppearanceNodeId> NodesInPolygon(const MapData& map, const NamedPolygon& polygon);
std::set<KeyframeId> KeyframesOfPlace(const MapData& map, const std::string& name);
std::set<AppearanceNodeId> NodesOfPlace(const MapData& map, const std::string& name);

// Those of a session, given by its number (from 1, in the order of `waystone info`) or its name,
// and its sequences. Throws MapError: kNotFound where there is none; kUsage where several have the
// name, or one has another one's number as its name.
std::set<KeyframeId> KeyframesOfSession(const MapData& map, const std::string& session);
std::set<AppearanceNodeId> NodesOfSession(const MapData& map, const std::string& session);
std::set<SequenceId> SequencesOfSession(const MapData& map, const std::string& session);

}  // namespace waystone
