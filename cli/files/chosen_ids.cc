// SPDX-License-Identifier: Apache-2.0
#include "cli/files/chosen_ids.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "api/query_request_json.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "localizer/index/named_places.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

[[noreturn]] void RefuseIds(NamedKind kind, const std::string& cause) {
  throw MapError(ErrorCode::kUsage, "--" + std::string(NameOf(kind)) + ": " + cause);
}

// "keyframe" of "keyframes".
std::string Singular(NamedKind kind) {
  const std::string_view name = NameOf(kind);
  return std::string(name.substr(0, name.size() - 1));
}

int64_t IdIn(const std::string& text, NamedKind kind, const std::vector<int64_t>& ids) {
  const std::optional<int64_t> id = ToInteger(text);
  if (!id) {
    RefuseIds(kind, QuoteShortened(text) + " is not an id; give ids as 12, 120:180 or 3,5,9:12");
  }
  if (std::ranges::binary_search(ids, *id)) return *id;
  throw MapError(ErrorCode::kNotFound,
                 "the map has no " + Singular(kind) + " " + std::to_string(*id) + "; " +
                     (ids.empty() ? "it has no " + std::string(NameOf(kind))
                                  : "its ids are from " + std::to_string(ids.front()) + " to " +
                                        std::to_string(ids.back())));
}

// Only what decides on membership in a place: no pictures, no planes.
MapData PartFor(const MapData& map, const NamedPlace& place) {
  MapData part;
  part.poses = map.poses;
  part.names = {place};
  for (const Keyframe& keyframe : map.keyframes) part.keyframes.emplace_back().id = keyframe.id;
  if (!map.appearance) return part;
  part.appearance.emplace();
  for (const AppearanceNode& node : map.appearance->nodes) {
    AppearanceNode& bare = part.appearance->nodes.emplace_back();
    bare.id = node.id;
    bare.pose = node.pose;
  }
  return part;
}

std::set<KeyframeId> KeyframesIn(const MapData& map, const NamedPlace& place) {
  const NamedPlaces places(PartFor(map, place));
  std::set<KeyframeId> held;
  for (const Keyframe& keyframe : map.keyframes) {
    if (places.OfKeyframe(keyframe.id) != nullptr) held.insert(keyframe.id);
  }
  return held;
}

std::set<AppearanceNodeId> NodesIn(const MapData& map, const NamedPlace& place) {
  std::set<AppearanceNodeId> held;
  if (!map.appearance) return held;
  const NamedPlaces places(PartFor(map, place));
  for (const AppearanceNode& node : map.appearance->nodes) {
    if (places.OfNode(node) != nullptr) held.insert(node.id);
  }
  return held;
}

const NamedPlace& FindPlace(const MapData& map, const std::string& name) {
  const auto found = std::ranges::find(map.names, name, &NamedPlace::name);
  if (found != map.names.end()) return *found;
  throw MapError(ErrorCode::kNotFound, "the map has no place named " + QuoteShortened(name) +
                                           "; it has " + std::to_string(map.names.size()) +
                                           ", which waystone name lists");
}

void RequirePositions(const MapData& map) {
  if (map.poses || map.appearance) return;
  throw MapError(ErrorCode::kNoLayer,
                 "the map has no positions for a region; build it with --poses, or give "
                 "keyframes");
}

// The ids in several lists of ids.
template <class IdType, class Row>
std::set<IdType> ChosenOf(const MapData& map, NamedKind kind, const std::vector<Row>& rows,
                          const std::vector<std::string>& texts) {
  std::set<IdType> chosen;
  for (const std::string& text : texts) {
    for (const NamedRange& range : RangesOfIds(map, kind, text)) {
      for (const Row& row : rows) {
        if (range.first <= row.id.value && row.id.value <= range.last) chosen.insert(row.id);
      }
    }
  }
  return chosen;
}

// The ids of the rows that are of some sequences.
template <class IdType, class Row>
std::set<IdType> IdsOfSequences(const std::vector<Row>& rows, const std::set<SequenceId>& chosen) {
  std::set<IdType> ids;
  for (const Row& row : rows) {
    if (chosen.contains(row.sequence)) ids.insert(row.id);
  }
  return ids;
}

const std::vector<AppearanceNode>& NodesOf(const MapData& map) {
  static const std::vector<AppearanceNode> none;
  return map.appearance ? map.appearance->nodes : none;
}

// The numbers, from 1, of the sessions with a name.
std::vector<int64_t> SessionsNamed(const std::vector<MapSession>& sessions,
                                   const std::string& name) {
  std::vector<int64_t> numbers;
  for (int64_t number = 1; const MapSession& session : sessions) {
    if (session.name == name) numbers.push_back(number);
    ++number;
  }
  return numbers;
}

// A session may have another one's number as its name.
const MapSession& FindSession(const std::vector<MapSession>& sessions, const std::string& text) {
  const auto at = [&](int64_t number) -> const MapSession& {
    return sessions[static_cast<size_t>(number - 1)];
  };
  const std::vector<int64_t> named = SessionsNamed(sessions, text);
  const std::optional<int64_t> number = ToInteger(text);
  const bool is_number = number && *number >= 1 && *number <= std::ssize(sessions);
  if (is_number && std::ranges::any_of(named, [&](int64_t other) { return other != *number; })) {
    throw MapError(ErrorCode::kUsage,
                   QuoteShortened(text) + " is the number of session " +
                       QuoteShortened(at(*number).name) + " and the name of session " +
                       std::to_string(named.front() != *number ? named.front() : named.back()) +
                       "; give the other name or number, or ids with --keyframes or --nodes");
  }
  if (named.size() > 1) {
    throw MapError(ErrorCode::kUsage, std::to_string(named.size()) + " sessions are named " +
                                          QuoteShortened(text) + "; give the number of one");
  }
  if (named.size() == 1) return at(named.front());
  if (is_number) return at(*number);
  throw MapError(ErrorCode::kNotFound, "the map has no session " + QuoteShortened(text) +
                                           "; it has " + std::to_string(sessions.size()) +
                                           ", which waystone info lists");
}

}  // namespace

std::vector<NamedRange> RangesOfIds(const MapData& map, NamedKind kind, const std::string& text) {
  const std::vector<int64_t> ids = IdsOf(map, kind);
  std::vector<NamedRange> ranges;
  std::istringstream words(text + ",");  // so that an empty last id is refused, too
  for (std::string word; std::getline(words, word, ',');) {
    const size_t colon = word.find(':');
    const int64_t first = IdIn(word.substr(0, colon), kind, ids);
    const int64_t last =
        colon == std::string::npos ? first : IdIn(word.substr(colon + 1), kind, ids);
    if (first > last) RefuseIds(kind, QuoteShortened(word) + " ends before it begins");
    ranges.push_back({kind, first, last});
  }
  return ranges;
}

std::set<KeyframeId> KeyframesOfIds(const MapData& map, const std::vector<std::string>& texts) {
  return ChosenOf<KeyframeId>(map, NamedKind::kKeyframes, map.keyframes, texts);
}

std::set<AppearanceNodeId> NodesOfIds(const MapData& map, const std::vector<std::string>& texts) {
  return ChosenOf<AppearanceNodeId>(map, NamedKind::kNodes, NodesOf(map), texts);
}

NamedPolygon ReadPolygon(const std::string& flag, const std::string& text) {
  NamedPolygon polygon;
  for (const std::string& word : Words(text)) {
    const size_t comma = word.find(',');
    const auto x = ToNumber(word.substr(0, comma));
    const auto y = comma == std::string::npos ? std::nullopt : ToNumber(word.substr(comma + 1));
    if (!x || !y) {
      throw MapError(ErrorCode::kUsage,
                     flag + ": " + QuoteShortened(word) +
                         " is not a corner; give corners as \"0,0 4.5,0 4.5,3\"");
    }
    polygon.emplace_back(*x, *y);
  }
  if (const auto problem = FindPolygonProblem(polygon)) {
    throw MapError(ErrorCode::kUsage, flag + " " + *problem);
  }
  return polygon;
}

std::set<KeyframeId> KeyframesInPolygon(const MapData& map, const NamedPolygon& polygon) {
  RequirePositions(map);
  return KeyframesIn(map, {"region", {}, {polygon}});
}

std::set<AppearanceNodeId> NodesInPolygon(const MapData& map, const NamedPolygon& polygon) {
  RequirePositions(map);
  return NodesIn(map, {"region", {}, {polygon}});
}

std::set<KeyframeId> KeyframesOfPlace(const MapData& map, const std::string& name) {
  return KeyframesIn(map, FindPlace(map, name));
}

std::set<AppearanceNodeId> NodesOfPlace(const MapData& map, const std::string& name) {
  return NodesIn(map, FindPlace(map, name));
}

std::set<SequenceId> SequencesOfSession(const MapData& map, const std::string& session) {
  const std::vector<MapSession> sessions = SessionsOf(map);
  const MapSession& chosen = FindSession(sessions, session);
  return {chosen.sequences.begin(), chosen.sequences.end()};
}

std::set<KeyframeId> KeyframesOfSession(const MapData& map, const std::string& session) {
  return IdsOfSequences<KeyframeId>(map.keyframes, SequencesOfSession(map, session));
}

std::set<AppearanceNodeId> NodesOfSession(const MapData& map, const std::string& session) {
  return IdsOfSequences<AppearanceNodeId>(NodesOf(map), SequencesOfSession(map, session));
}

}  // namespace waystone
