// SPDX-License-Identifier: Apache-2.0
#include "api/hints_json.h"

#include <cmath>
#include <string>

#include "api/query_request_json.h"

namespace waystone {
namespace {

constexpr size_t kMaxTags = 32;
constexpr double kMaxCoordinate = 1e9;  // of a frame's units

double CoordinateIn(const Json& position, const char* name, double low) {
  const std::string field = std::string("hints.position.") + name;
  if (!position.contains(name)) RefuseRequest(field + " is missing");
  const Json& value = position[name];
  if (value.is_number()) {
    const auto number = value.get<double>();
    if (number >= low && number <= kMaxCoordinate) return number;
  }
  RefuseRequest(field + " must be a number between " + Dump(Json(low)) + " and " +
                Dump(Json(kMaxCoordinate)));
}

PositionHint ReadPosition(const Json& json) {
  CheckKnownFields(json, "hints.position", {"frame", "radius", "x", "y", "z"});
  PositionHint position;
  if (!json.contains("frame")) RefuseRequest("hints.position.frame is missing");
  position.frame = NameIn(json["frame"], "hints.position.frame");
  position.at = {CoordinateIn(json, "x", -kMaxCoordinate),
                 CoordinateIn(json, "y", -kMaxCoordinate)};
  if (json.contains("z")) position.at.push_back(CoordinateIn(json, "z", -kMaxCoordinate));
  position.radius = CoordinateIn(json, "radius", 0);
  return position;
}

}  // namespace

MapHints ReadHints(const Json& object) {
  CheckKnownFields(object, "hints", {"position", "previous_map", "tags"});
  MapHints hints;
  if (object.contains("position")) hints.position = ReadPosition(object["position"]);
  if (object.contains("previous_map")) {
    hints.previous_map = NameIn(object["previous_map"], "hints.previous_map");
  }
  if (!object.contains("tags")) return hints;
  const Json& tags = object["tags"];
  if (!tags.is_array() || tags.size() > kMaxTags) {
    RefuseRequest("hints.tags must be a list of at most " + std::to_string(kMaxTags) + " tags");
  }
  for (const Json& tag : tags) hints.tags.push_back(NameIn(tag, "a tag of hints.tags"));
  return hints;
}

Json ToJson(const MapHints& hints) {
  Json json = Json::object();
  if (hints.position) {
    const PositionHint& position = *hints.position;
    json["position"] = {{"frame", position.frame},
                        {"x", position.at.at(0)},
                        {"y", position.at.at(1)},
                        {"radius", position.radius}};
    if (position.at.size() > 2) json["position"]["z"] = position.at[2];
  }
  if (hints.previous_map) json["previous_map"] = *hints.previous_map;
  if (!hints.tags.empty()) json["tags"] = hints.tags;
  return json;
}

}  // namespace waystone
