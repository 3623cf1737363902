// SPDX-License-Identifier: Apache-2.0
#include "api/history_json.h"

#include "schema/sessions.h"

namespace waystone {
namespace {

Json SessionJson(const MapData& map, const MapSession& session) {
  const SessionContents held = ContentsOf(map, session);
  Json json;
  json["name"] = session.name;
  json["program"] = session.program;
  json["version"] = session.version.empty() ? Json(nullptr) : Json(session.version);
  json["sequences"] = ToJson(session.sequences);
  json["keyframes"] = held.keyframes;
  json["panoramas"] = held.panoramas;
  json["orientation_frames"] = held.orientation_frames;
  json["from_s"] = OrNull(held.from_s);
  json["to_s"] = OrNull(held.to_s);
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
