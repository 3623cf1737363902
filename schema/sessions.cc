// SPDX-License-Identifier: Apache-2.0
#include "schema/sessions.h"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

namespace waystone {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSessionsKey = "sessions";

// Deeper than any record of options; writing takes stack for each level.
constexpr int kMaxDepth = 32;

// The record as an object; empty where it isn't one.
Json ParseRecord(const std::string& options_json) {
  const auto is_shallow = [](int depth, Json::parse_event_t, const Json&) {
    return depth <= kMaxDepth;
  };
  Json record = Json::parse(options_json, is_shallow, false);
  return record.is_object() ? record : Json::object();
}

std::string Text(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

std::optional<MapSession> ReadSession(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  MapSession session{Text(json, "name"), Text(json, "program"), Text(json, "version"), {}};
  const auto ids = json.find("sequences");
  if (ids == json.end() || !ids->is_array()) return std::nullopt;
  for (const Json& id : *ids) {
    if (!id.is_number_integer()) return std::nullopt;
    session.sequences.push_back({id.get<int64_t>()});
  }
  if (!std::ranges::is_sorted(session.sequences)) return std::nullopt;
  return session;
}

// Nothing where the record has no history, or one that isn't of these sequences.
std::optional<std::vector<MapSession>> ReadSessions(const MapData& map) {
  const Json record = ParseRecord(map.info.options_json);
  const auto list = record.find(kSessionsKey);
  if (list == record.end() || !list->is_array()) return std::nullopt;
  std::vector<MapSession> sessions;
  std::vector<SequenceId> named;
  for (const Json& json : *list) {
    std::optional<MapSession> session = ReadSession(json);
    if (!session) return std::nullopt;
    named.insert(named.end(), session->sequences.begin(), session->sequences.end());
    sessions.push_back(std::move(*session));
  }
  std::vector<SequenceId> all;
  for (const Sequence& sequence : map.sequences) all.push_back(sequence.id);
  std::ranges::sort(named);
  std::ranges::sort(all);
  if (named != all) return std::nullopt;
  return sessions;
}

// Counts the items of the session; their times extend the span.
template <class Items>
int CountOfSession(const Items& items, const MapSession& session, SessionContents& contents) {
  int count = 0;
  for (const auto& item : items) {
    if (!std::ranges::binary_search(session.sequences, item.sequence)) continue;
    ++count;
    if (!item.time_s) continue;
    contents.from_s = std::min(contents.from_s.value_or(*item.time_s), *item.time_s);
    contents.to_s = std::max(contents.to_s.value_or(*item.time_s), *item.time_s);
  }
  return count;
}

// Sequences whose nodes an edge joins.
template <class Edges, class NodeId>
void UniteEdges(const Edges& edges, const std::map<NodeId, size_t>& sequence_of,
                boost::disjoint_sets_with_storage<>& parts) {
  for (const auto& edge : edges) parts.union_set(sequence_of.at(edge.a), sequence_of.at(edge.b));
}

}  // namespace

std::vector<MapSession> SessionsOf(const MapData& map) {
  if (auto sessions = ReadSessions(map)) return *sessions;
  MapSession own{map.info.name, map.info.program, map.info.version, {}};
  for (const Sequence& sequence : map.sequences) own.sequences.push_back(sequence.id);
  std::ranges::sort(own.sequences);
  return {own};
}

bool HasHistory(const MapData& map) { return ReadSessions(map).has_value(); }

SessionContents ContentsOf(const MapData& map, const MapSession& session) {
  SessionContents contents;
  contents.keyframes = CountOfSession(map.keyframes, session, contents);
  if (map.appearance) {
    contents.panoramas = CountOfSession(map.appearance->nodes, session, contents);
  }
  if (map.orientation) {
    contents.orientation_frames = CountOfSession(map.orientation->frames, session, contents);
  }
  return contents;
}

std::string WithSessions(const std::string& options_json, const std::vector<MapSession>& sessions) {
  Json record = ParseRecord(options_json);
  Json list = Json::array();
  for (const MapSession& session : sessions) {
    Json json;
    json["name"] = session.name;
    json["program"] = session.program;
    json["version"] = session.version;
    json["sequences"] = Json::array();
    for (const SequenceId id : session.sequences) json["sequences"].push_back(id.value);
    list.push_back(std::move(json));
  }
  record[kSessionsKey] = std::move(list);
  return record.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string WithoutSessions(const std::string& options_json) {
  Json record = ParseRecord(options_json);
  if (record.erase(kSessionsKey) == 0) return options_json;
  return record.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::vector<std::vector<SequenceId>> FindParts(const MapData& map) {
  std::map<SequenceId, size_t> number;
  for (const Sequence& sequence : map.sequences) number.emplace(sequence.id, number.size());
  std::map<KeyframeId, size_t> of_keyframe;
  for (const Keyframe& keyframe : map.keyframes) {
    of_keyframe[keyframe.id] = number.at(keyframe.sequence);
  }
  boost::disjoint_sets_with_storage<> parts(number.size());
  std::map<PlaneId, size_t> of_plane;
  for (const Plane& plane : map.planes) {
    of_plane[plane.id] = of_keyframe.at(plane.reference);
    for (const PlaneView& view : plane.views) {
      parts.union_set(of_plane[plane.id], of_keyframe.at(view.keyframe));
    }
  }
  for (const Edge& edge : map.edges) parts.union_set(of_plane.at(edge.a), of_plane.at(edge.b));
  for (const KeyframeLink& link : map.links) {
    parts.union_set(of_keyframe.at(link.a), of_keyframe.at(link.b));
  }
  if (map.appearance) {
    std::map<AppearanceNodeId, size_t> of_node;
    for (const AppearanceNode& node : map.appearance->nodes) {
      of_node[node.id] = number.at(node.sequence);
    }
    UniteEdges(map.appearance->edges, of_node, parts);
  }
  if (map.orientation) {
    std::map<OrientationFrameId, size_t> of_frame;
    for (const OrientationFrame& frame : map.orientation->frames) {
      of_frame[frame.id] = number.at(frame.sequence);
    }
    UniteEdges(map.orientation->edges, of_frame, parts);
  }
  std::map<size_t, size_t> part_of_set;
  std::vector<std::vector<SequenceId>> found;
  for (const auto& [id, i] : number) {
    const auto [part, is_new] = part_of_set.emplace(parts.find_set(i), found.size());
    if (is_new) found.emplace_back();
    found[part->second].push_back(id);
  }
  return found;
}

}  // namespace waystone
