// SPDX-License-Identifier: Apache-2.0
#include "api/query_request_json.h"

#include <cmath>
#include <numbers>

#include "api/hints_json.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/geometry/angle.h"

namespace waystone {

void RequestLimits::Check() const { CheckFields("limits", *this); }

void RefuseRequest(const std::string& cause) { throw MapError(ErrorCode::kBadRequest, cause); }

std::string QuoteShortened(const std::string& text) {
  constexpr size_t kShown = 40;
  return "'" + Printable(std::string_view(text).substr(0, kShown)) + "'";
}

namespace {

constexpr int kMaxTopK = 50;
constexpr size_t kMaxBeliefs = 1000;
constexpr size_t kMaxMotions = 64;      // no request has more images
constexpr double kMaxTrajectory = 1e9;  // of a layer's units
constexpr double kMaxPixel = 100'000;   // of focal lengths and principal points
constexpr double kMinFovDeg = 1;
constexpr double kMaxFovDeg = 179;

// Counts what is parsed, and keeps the field names of the open objects.
class JsonWatch {
 public:
  explicit JsonWatch(const JsonBounds& bounds) : bounds_(bounds) {}

  void See(int depth, Json::parse_event_t event, const Json& value) {
    if (depth > bounds_.depth) RefuseRequest("the JSON is nested too deeply");
    const bool ends =
        event == Json::parse_event_t::array_end || event == Json::parse_event_t::object_end;
    if (!ends && ++values_ > bounds_.values) RefuseRequest("the JSON has too many values");
    if (event == Json::parse_event_t::object_start) names_.emplace_back();
    if (event == Json::parse_event_t::object_end) names_.pop_back();
    if (event == Json::parse_event_t::key) SeeName(value.get_ref<const std::string&>());
  }

 private:
  void SeeName(const std::string& name) {
    if (name.size() > kMaxFieldBytes) {
      RefuseRequest("the JSON has a field whose name has " + std::to_string(name.size()) +
                    " bytes; the limit is " + std::to_string(kMaxFieldBytes));
    }
    if (!names_.back().insert(name).second) {
      RefuseRequest("the JSON has the field " + QuoteShortened(name) +
                    " more than once in an object; give it once");
    }
    if (names_.back().size() > kMaxFields) {
      RefuseRequest("the JSON has an object of more than " + std::to_string(kMaxFields) +
                    " fields; leave out those that aren't known");
    }
  }

  const JsonBounds bounds_;
  int values_ = 0;
  std::vector<std::set<std::string>> names_;
};

}  // namespace

Json ParseJson(std::string_view text, const JsonBounds& bounds) {
  JsonWatch watch(bounds);
  const auto see = [&](int depth, Json::parse_event_t event, const Json& value) {
    watch.See(depth, event, value);
    return true;
  };
  try {
    return Json::parse(text, see);
  } catch (const Json::parse_error& error) {
    if (error.byte > text.size()) {
      RefuseRequest("invalid JSON: it ends too early, after " + std::to_string(text.size()) +
                    " bytes");
    }
    RefuseRequest("invalid JSON: unexpected text at byte " + std::to_string(error.byte));
  } catch (const Json::exception&) {
    RefuseRequest("invalid JSON: a number in it is too large");
  }
}

std::optional<int64_t> WholeNumber(const Json& value) {
  constexpr double kEnd = 0x1p63;  // one past the largest
  if (value.is_number_unsigned() && value.get<uint64_t>() > INT64_MAX) return std::nullopt;
  if (value.is_number_integer()) return value.get<int64_t>();
  if (!value.is_number_float()) return std::nullopt;
  const auto number = value.get<double>();
  if (number != std::floor(number) || number < -kEnd || number >= kEnd) return std::nullopt;
  return static_cast<int64_t>(number);
}

std::string NameIn(const Json& value, const std::string& field) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > kMaxNameBytes) {
    RefuseRequest(field + " must be a string of at most " + std::to_string(kMaxNameBytes) +
                  " bytes");
  }
  return value.get<std::string>();
}

void CheckKnownFields(const Json& object, const std::string& what,
                      const std::set<std::string>& known) {
  if (!object.is_object()) RefuseRequest(what + " must be a JSON object");
  for (const auto& [name, value] : object.items()) {
    if (known.contains(name)) continue;
    std::string list;
    for (const std::string& field : known) list += (list.empty() ? "" : ", ") + field;
    RefuseRequest(what + " has an unknown field " + QuoteShortened(name) +
                  "; known fields: " + list);
  }
}

namespace {

double NumberIn(const Json& value, const std::string& field, double low, double high) {
  if (value.is_number()) {
    const double number = value.get<double>();
    if (number >= low && number <= high) return number;
  }
  RefuseRequest(field + " must be a number between " + Dump(Json(low)) + " and " +
                Dump(Json(high)));
}

int64_t WholeIn(const Json& value, const std::string& field, int64_t low, int64_t high) {
  const std::optional<int64_t> number = WholeNumber(value);
  if (number && *number >= low && *number <= high) return *number;
  RefuseRequest(field + " must be an integer between " + std::to_string(low) + " and " +
                std::to_string(high));
}

bool FlagIn(const Json& value, const std::string& field) {
  if (!value.is_boolean()) RefuseRequest(field + " must be true or false");
  return value.get<bool>();
}

Intrinsics ReadIntrinsics(const Json& object) {
  const auto of = [&](const char* name, double low) {
    if (!object.contains(name))
      RefuseRequest("fx, fy, cx and cy must be given together; " + std::string(name) +
                    " is missing");
    return NumberIn(object[name], name, low, kMaxPixel);
  };
  constexpr double kMinFocal = 1;
  return {of("fx", kMinFocal), of("fy", kMinFocal), of("cx", -kMaxPixel), of("cy", -kMaxPixel)};
}

double AngleIn(const Json& object, const char* name, const std::string& field) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return NumberIn(object[name], field, -kTurn, kTurn);
}

NodeBelief ReadNodeBelief(const Json& one) {
  const std::set<std::string> fields = {"deviation_rad", "heading_rad", "node", "probability"};
  CheckKnownFields(one, "a belief", fields);
  for (const std::string& name : fields) {
    if (!one.contains(name)) RefuseRequest("a belief has no " + name);
  }
  return {AppearanceNodeId{WholeIn(one["node"], "previous.belief's node", 1, INT64_MAX)},
          NumberIn(one["probability"], "previous.belief's probability", 0, 1),
          AngleIn(one, "heading_rad", "previous.belief's heading_rad"),
          NumberIn(one["deviation_rad"], "previous.belief's deviation_rad", 1e-9, 1e3)};
}

std::vector<NodeBelief> ReadBelief(const Json& list) {
  if (!list.is_array() || list.size() > kMaxBeliefs) {
    RefuseRequest("previous.belief must be a list of at most " + std::to_string(kMaxBeliefs) +
                  " nodes, as returned in an answer");
  }
  std::vector<NodeBelief> belief;
  for (const Json& one : list) belief.push_back(ReadNodeBelief(one));
  return belief;
}

PreviousAnswer ReadPrevious(const Json& object) {
  CheckKnownFields(object, "previous", {"belief", "heading_rad", "keyframe", "map_version"});
  PreviousAnswer previous;
  if (object.contains("keyframe")) {
    previous.keyframe = KeyframeId{WholeIn(object["keyframe"], "previous.keyframe", 1, INT64_MAX)};
  }
  if (object.contains("heading_rad")) {
    previous.heading_rad = AngleIn(object, "heading_rad", "previous.heading_rad");
  }
  if (object.contains("map_version")) {
    previous.map_version = NameIn(object["map_version"], "previous.map_version");
  }
  if (object.contains("belief")) previous.belief = ReadBelief(object["belief"]);
  return previous;
}

std::vector<std::optional<Pose2>> ReadOdometry(const Json& list) {
  if (!list.is_array() || list.empty() || list.size() > kMaxMotions) {
    RefuseRequest("odometry must be a list with a motion or null for each image");
  }
  std::vector<std::optional<Pose2>> motions;
  for (const Json& one : list) {
    if (one.is_null()) {
      motions.emplace_back();
      continue;
    }
    CheckKnownFields(one, "a motion", {"heading_rad", "x", "y"});
    for (const char* name : {"heading_rad", "x", "y"}) {
      if (!one.contains(name)) RefuseRequest("a motion has no " + std::string(name));
    }
    const Pose2 motion = {NumberIn(one["x"], "odometry's x", -kMaxTrajectory, kMaxTrajectory),
                          NumberIn(one["y"], "odometry's y", -kMaxTrajectory, kMaxTrajectory),
                          AngleIn(one, "heading_rad", "odometry's heading_rad")};
    motions.emplace_back(motion);
  }
  return motions;
}

void ReadCamera(const Json& object, QueryRequest& request) {
  for (const char* name : {"fx", "fy", "cx", "cy"}) {
    if (object.contains(name) && !request.intrinsics) request.intrinsics = ReadIntrinsics(object);
  }
  if (object.contains("fov_deg")) {
    request.fov_rad = kDegree * NumberIn(object["fov_deg"], "fov_deg", kMinFovDeg, kMaxFovDeg);
  }
  if (object.contains("camera")) request.stored_camera = NameIn(object["camera"], "camera");
  const int given = int{request.intrinsics.has_value()} + int{request.fov_rad.has_value()} +
                    int{request.stored_camera.has_value()};
  if (given > 1)
    RefuseRequest(
        "the camera is given more than once; use either fx, fy, cx and cy, fov_deg, or camera");
}

Json PreviousJson(const PreviousAnswer& previous) {
  Json json = Json::object();
  if (previous.keyframe) json["keyframe"] = previous.keyframe->value;
  if (previous.heading_rad) json["heading_rad"] = *previous.heading_rad;
  if (previous.map_version) json["map_version"] = *previous.map_version;
  if (previous.belief) json["belief"] = ToJson(*previous.belief);
  return json;
}

}  // namespace

QueryRequest ParseQueryRequest(const Json& object, const RequestLimits& limits, bool with_images) {
  std::set<std::string> known = {"camera",   "cx",    "cy",   "deadline_ms", "debug",
                                 "fov_deg",  "fx",    "fy",   "hints",       "odometry",
                                 "previous", "prior", "top_k"};
  if (with_images) known.insert("images");
  CheckKnownFields(object, "the request", known);
  QueryRequest request;
  ReadCamera(object, request);
  if (object.contains("prior")) {
    CheckKnownFields(object["prior"], "prior", {"keyframe"});
    if (!object["prior"].contains("keyframe")) RefuseRequest("prior has no keyframe");
    request.prior_keyframe =
        KeyframeId{WholeIn(object["prior"]["keyframe"], "prior.keyframe", 1, INT64_MAX)};
  }
  if (object.contains("previous")) request.previous = ReadPrevious(object["previous"]);
  if (object.contains("odometry")) request.odometry = ReadOdometry(object["odometry"]);
  if (object.contains("hints")) request.hints = ReadHints(object["hints"]);
  if (object.contains("top_k")) {
    request.top_k = static_cast<int>(WholeIn(object["top_k"], "top_k", 1, kMaxTopK));
  }
  if (object.contains("debug")) request.debug = FlagIn(object["debug"], "debug");
  if (object.contains("deadline_ms")) {
    request.deadline_ms =
        static_cast<int>(WholeIn(object["deadline_ms"], "deadline_ms", 1, limits.max_deadline_ms));
  }
  return request;
}

void CheckOdometry(const QueryRequest& request) {
  if (request.odometry.empty() || request.odometry.size() == request.images.size()) return;
  RefuseRequest("odometry has " + std::to_string(request.odometry.size()) + " motions for " +
                std::to_string(request.images.size()) +
                " images; give one motion or null per image");
}

Json ToJson(const std::vector<NodeBelief>& belief) {
  Json list = Json::array();
  for (const NodeBelief& one : belief) {
    list.push_back({{"node", one.node.value},
                    {"probability", one.probability},
                    {"heading_rad", one.heading_rad},
                    {"deviation_rad", one.sigma_rad}});
  }
  return list;
}

Json ToJson(const QueryRequest& request) {
  Json json = Json::object();
  if (request.intrinsics) {
    json["fx"] = request.intrinsics->fx;
    json["fy"] = request.intrinsics->fy;
    json["cx"] = request.intrinsics->cx;
    json["cy"] = request.intrinsics->cy;
  }
  if (request.fov_rad) json["fov_deg"] = *request.fov_rad / kDegree;
  if (request.stored_camera) json["camera"] = *request.stored_camera;
  if (request.prior_keyframe) json["prior"] = {{"keyframe", request.prior_keyframe->value}};
  if (request.previous) json["previous"] = PreviousJson(*request.previous);
  for (const std::optional<Pose2>& motion : request.odometry) {
    json["odometry"].push_back(
        motion ? Json{{"x", motion->x}, {"y", motion->y}, {"heading_rad", motion->theta_rad}}
               : Json(nullptr));
  }
  if (request.hints) json["hints"] = ToJson(*request.hints);
  if (request.top_k) json["top_k"] = *request.top_k;
  if (request.debug) json["debug"] = true;
  if (request.deadline_ms) json["deadline_ms"] = *request.deadline_ms;
  return json;
}

}  // namespace waystone
