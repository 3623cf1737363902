// SPDX-License-Identifier: Apache-2.0
#include "api/history_json.h"

#include <algorithm>
#include <optional>

#include "schema/sessions.h"

namespace waystone {
namespace {

// Times are those of its keyframes.
Json SessionJson(const MapData& map, const MapSession& session) {
  int64_t keyframes = 0;
  std::optional<double> from_s;
  std::optional<double> to_s;
  for (const Keyframe& keyframe : map.keyframes) {
    if (!std::ranges::binary_search(session.sequences, keyframe.sequence)) continue;
    ++keyframes;
    if (!keyframe.time_s) continue;
    from_s = std::min(from_s.value_or(*keyframe.time_s), *keyframe.time_s);
    to_s = std::max(to_s.value_or(*keyframe.time_s), *keyframe.time_s);
  }
  Json json;
  json["name"] = session.name;
  json["program"] = session.program;
  json["version"] = session.version.empty() ? Json(nullptr) : Json(session.version);
  json["sequences"] = ToJson(session.sequences);
  json["keyframes"] = keyframes;
  json["from_s"] = OrNull(from_s);
  json["to_s"] = OrNull(to_s);
  return json;
}

}  // namespace

Json SessionsJson(const MapData& map) {
  Json list = Json::array();
  for (const MapSession& session : SessionsOf(map)) list.push_back(SessionJson(map, session));
  return list;
}

Json PartsJson(const MapData& map) {
  Json list = Json::array();
  for (const std::vector<SequenceId>& part : FindParts(map)) list.push_back(ToJson(part));
  return list;
}

}  // namespace waystone
