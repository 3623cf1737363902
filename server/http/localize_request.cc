// SPDX-License-Identifier: Apache-2.0
#include "server/http/localize_request.h"

#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "core/base/angle.h"
#include "core/base/error.h"
#include "core/image/exif.h"
#include "server/http/body_parts.h"

namespace waystone {
namespace {

constexpr size_t kMaxNameBytes = 200;       // longest name of an image that an answer repeats
constexpr size_t kMaxObjectBytes = 65'536;  // of a form's part `request`
constexpr int kMaxDepth = 8;                // of JSON: nothing we read is deeper
constexpr int kMaxTopK = 50;
constexpr size_t kMaxBeliefs = 1000;
constexpr size_t kMaxMotions = 64;      // no request has more images
constexpr double kMaxTrajectory = 1e9;  // of a layer's units
constexpr double kMaxPixel = 100'000;   // of focal lengths and principal points
constexpr double kMinFovDeg = 1;
constexpr double kMaxFovDeg = 179;

[[noreturn]] void Refuse(const std::string& cause) {
  throw MapError(ErrorCode::kBadRequest, cause);
}

std::string Short(const std::string& text) { return "'" + text.substr(0, 40) + "'"; }

// ---- JSON

Json ParseJson(std::string_view text) {
  const auto bounded = [](int depth, Json::parse_event_t, const Json&) {
    if (depth > kMaxDepth) Refuse("the JSON is nested too deeply");
    return true;
  };
  try {
    return Json::parse(text, bounded);
  } catch (const Json::exception& error) {
    Refuse("invalid JSON: " + std::string(error.what()).substr(0, 120));
  }
}

double NumberIn(const Json& value, const std::string& field, double low, double high) {
  if (value.is_number()) {
    const double number = value.get<double>();
    if (number >= low && number <= high) return number;
  }
  Refuse(field + " must be a number between " + Dump(Json(low)) + " and " + Dump(Json(high)));
}

int64_t WholeIn(const Json& value, const std::string& field, int64_t low, int64_t high) {
  if (value.is_number_integer()) {
    const bool fits = !value.is_number_unsigned() || value.get<uint64_t>() <= INT64_MAX;
    const int64_t number = fits ? value.get<int64_t>() : -1;
    if (fits && number >= low && number <= high) return number;
  }
  Refuse(field + " must be an integer between " + std::to_string(low) + " and " +
         std::to_string(high));
}

std::string TextIn(const Json& value, const std::string& field) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > kMaxNameBytes) {
    Refuse(field + " must be a string of at most " + std::to_string(kMaxNameBytes) + " bytes");
  }
  return value.get<std::string>();
}

bool FlagIn(const Json& value, const std::string& field) {
  if (!value.is_boolean()) Refuse(field + " must be true or false");
  return value.get<bool>();
}

void CheckFields(const Json& object, const std::string& what, const std::set<std::string>& known) {
  if (!object.is_object()) Refuse(what + " must be a JSON object");
  for (const auto& [name, value] : object.items()) {
    if (known.contains(name)) continue;
    std::string list;
    for (const std::string& field : known) list += (list.empty() ? "" : ", ") + field;
    Refuse(what + " has an unknown field " + Short(name) + "; known fields: " + list);
  }
}

Intrinsics ReadIntrinsics(const Json& object) {
  const auto of = [&](const char* name, double low) {
    if (!object.contains(name))
      Refuse("fx, fy, cx and cy must be given together; " + std::string(name) + " is missing");
    return NumberIn(object[name], name, low, kMaxPixel);
  };
  constexpr double kMinFocal = 1;
  return {of("fx", kMinFocal), of("fy", kMinFocal), of("cx", -kMaxPixel), of("cy", -kMaxPixel)};
}

double AngleIn(const Json& object, const char* name, const std::string& field) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return NumberIn(object[name], field, -kTurn, kTurn);
}

void CheckBelief(const Json& belief) {
  if (!belief.is_array() || belief.size() > kMaxBeliefs) {
    Refuse("previous.belief must be a list of at most " + std::to_string(kMaxBeliefs) +
           " nodes, as returned in an answer");
  }
  for (const Json& one : belief) {
    CheckFields(one, "a belief", {"deviation_rad", "heading_rad", "node", "probability"});
    for (const char* name : {"deviation_rad", "heading_rad", "node", "probability"}) {
      if (!one.contains(name)) Refuse("a belief has no " + std::string(name));
    }
    WholeIn(one["node"], "previous.belief's node", 1, INT64_MAX);
    NumberIn(one["probability"], "previous.belief's probability", 0, 1);
    AngleIn(one, "heading_rad", "previous.belief's heading_rad");
    NumberIn(one["deviation_rad"], "previous.belief's deviation_rad", 1e-9, 1e3);
  }
}

Json ReadPrevious(const Json& previous) {
  CheckFields(previous, "previous", {"belief", "heading_rad", "keyframe", "map_version"});
  if (previous.contains("keyframe")) {
    WholeIn(previous["keyframe"], "previous.keyframe", 1, INT64_MAX);
  }
  if (previous.contains("heading_rad")) {
    AngleIn(previous, "heading_rad", "previous.heading_rad");
  }
  if (previous.contains("map_version")) TextIn(previous["map_version"], "previous.map_version");
  if (previous.contains("belief")) CheckBelief(previous["belief"]);
  return previous;
}

std::vector<std::optional<Pose2>> ReadOdometry(const Json& list) {
  if (!list.is_array() || list.empty() || list.size() > kMaxMotions) {
    Refuse("odometry must be a list with a motion or null for each image");
  }
  std::vector<std::optional<Pose2>> motions;
  for (const Json& one : list) {
    if (one.is_null()) {
      motions.emplace_back();
      continue;
    }
    CheckFields(one, "a motion", {"heading_rad", "x", "y"});
    for (const char* name : {"heading_rad", "x", "y"}) {
      if (!one.contains(name)) Refuse("a motion has no " + std::string(name));
    }
    const Pose2 motion = {NumberIn(one["x"], "odometry's x", -kMaxTrajectory, kMaxTrajectory),
                          NumberIn(one["y"], "odometry's y", -kMaxTrajectory, kMaxTrajectory),
                          AngleIn(one, "heading_rad", "odometry's heading_rad")};
    motions.emplace_back(motion);
  }
  return motions;
}

void ReadCamera(const Json& object, LocalizeRequest& request) {
  for (const char* name : {"fx", "fy", "cx", "cy"}) {
    if (object.contains(name) && !request.intrinsics) request.intrinsics = ReadIntrinsics(object);
  }
  if (object.contains("fov_deg")) {
    request.fov_rad = kDegree * NumberIn(object["fov_deg"], "fov_deg", kMinFovDeg, kMaxFovDeg);
  }
  if (object.contains("camera")) request.stored_camera = TextIn(object["camera"], "camera");
  const int given = int{request.intrinsics.has_value()} + int{request.fov_rad.has_value()} +
                    int{request.stored_camera.has_value()};
  if (given > 1)
    Refuse("the camera is given more than once; use either fx, fy, cx and cy, fov_deg, or camera");
}

LocalizeRequest ReadObject(const Json& object, const RequestLimits& limits, bool images) {
  std::set<std::string> known = {"camera", "cx", "cy",       "deadline_ms", "debug", "fov_deg",
                                 "fx",     "fy", "odometry", "previous",    "prior", "top_k"};
  if (images) known.insert("images");
  CheckFields(object, "the request", known);
  LocalizeRequest request;
  ReadCamera(object, request);
  if (object.contains("prior")) {
    CheckFields(object["prior"], "prior", {"keyframe"});
    if (!object["prior"].contains("keyframe")) Refuse("prior has no keyframe");
    request.prior_keyframe = WholeIn(object["prior"]["keyframe"], "prior.keyframe", 1, INT64_MAX);
  }
  if (object.contains("previous")) request.previous = ReadPrevious(object["previous"]);
  if (object.contains("odometry")) request.odometry = ReadOdometry(object["odometry"]);
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

// ---- the three kinds of bodies

// A query parameter as the JSON that it stands for.
Json ParameterValue(const std::string& name, const std::string& text) {
  if (name == "camera") return text;
  if (name == "debug") {
    if (text == "true" || text == "1" || text.empty()) return true;
    if (text == "false" || text == "0") return false;
    Refuse("debug=" + text.substr(0, 40) + " must be true or false");
  }
  Json value = Json::parse(text, nullptr, false);
  if (!value.is_number()) Refuse(name + "=" + text.substr(0, 40) + " is not a number");
  return value;
}

LocalizeRequest ReadRaw(const HttpRequest& http, const RequestLimits& limits) {
  Json object = Json::object();
  QueryImage image{"query", ""};
  for (const auto& [name, text] : http.query) {
    if (name == "name") {
      image.name = text.substr(0, kMaxNameBytes);
    } else if (name == "prior_keyframe") {
      object["prior"]["keyframe"] = ParameterValue(name, text);
    } else if (name == "prior" || name == "previous" || name == "odometry" || name == "images") {
      Refuse(name + " must be in a JSON body; the query parameter is prior_keyframe");
    } else {
      object[name] = ParameterValue(name, text);
    }
  }
  LocalizeRequest request = ReadObject(object, limits, false);
  image.bytes = http.read_body();
  request.images.push_back(std::move(image));
  return request;
}

void RefuseParameters(const HttpRequest& http) {
  if (http.query.empty()) return;
  Refuse("with such a body, parameters must be in its JSON and not in the URL; move " +
         Short(http.query.begin()->first));
}

void CheckCount(const LocalizeRequest& request, const RequestLimits& limits) {
  if (request.images.empty()) Refuse("the body has no image");
  if (request.images.size() > static_cast<size_t>(limits.max_images)) {
    Refuse(std::to_string(request.images.size()) + " images; the limit is " +
           std::to_string(limits.max_images) + " per request");
  }
  if (!request.odometry.empty() && request.odometry.size() != request.images.size()) {
    Refuse("odometry has " + std::to_string(request.odometry.size()) + " motions for " +
           std::to_string(request.images.size()) + " images; give one motion or null per image");
  }
}

LocalizeRequest ReadForm(const HttpRequest& http, const std::string& type,
                         const RequestLimits& limits) {
  RefuseParameters(http);
  const std::string body = http.read_body();
  const size_t max_parts = static_cast<size_t>(limits.max_images) + 1;
  LocalizeRequest request;
  std::vector<QueryImage> images;
  bool described = false;
  for (const BodyPart& part : ParseMultipart(body, type, max_parts)) {
    if (part.name == "image") {
      const std::string name = part.filename.empty() ? "image " + std::to_string(images.size() + 1)
                                                     : part.filename.substr(0, kMaxNameBytes);
      images.push_back({name, std::string(part.bytes)});
    } else if (part.name == "request") {
      if (std::exchange(described, true)) Refuse("the form has more than one part 'request'");
      if (part.bytes.size() > kMaxObjectBytes) Refuse("the part 'request' exceeds 64 KiB");
      request = ReadObject(ParseJson(part.bytes), limits, false);
    } else {
      Refuse("the form has an unknown part " + Short(part.name) +
             "; known parts: 'image' and 'request'");
    }
  }
  request.images = std::move(images);
  CheckCount(request, limits);
  return request;
}

LocalizeRequest ReadJson(const HttpRequest& http, const RequestLimits& limits) {
  RefuseParameters(http);
  const Json object = ParseJson(http.read_body());
  LocalizeRequest request = ReadObject(object, limits, true);
  if (!object.contains("images") || !object["images"].is_array()) {
    Refuse("images must be a list of {\"name\", \"data\": base64}");
  }
  for (const Json& image : object["images"]) {
    CheckFields(image, "an image", {"data", "name"});
    if (!image.contains("data") || !image["data"].is_string()) {
      Refuse("an image has no data; send its bytes as base64");
    }
    const std::string name = image.contains("name")
                                 ? TextIn(image["name"], "an image's name")
                                 : "image " + std::to_string(request.images.size() + 1);
    request.images.push_back({name, DecodeBase64(image["data"].get_ref<const std::string&>())});
    if (request.images.size() > static_cast<size_t>(limits.max_images)) break;
  }
  CheckCount(request, limits);
  return request;
}

const Sequence* SequenceNamed(const MapData& map, const std::string& name) {
  for (const Sequence& sequence : map.sequences) {
    if (sequence.name == name && sequence.camera) return &sequence;
  }
  return nullptr;
}

Camera StoredCamera(const MapData& map, const std::string& name, const ImageHeader& image) {
  const Sequence* sequence = SequenceNamed(map, name);
  if (!sequence) {
    std::string names;
    for (const Sequence& other : map.sequences) {
      if (other.camera) names += (names.empty() ? "" : ", ") + Short(other.name);
    }
    throw MapError(ErrorCode::kBadCamera, "the map has no camera " + Short(name) +
                                              (names.empty() ? "; it was built without cameras"
                                                             : "; its cameras are " + names));
  }
  const Camera& camera = *sequence->camera;
  if (camera.width != image.width || camera.height != image.height) {
    throw MapError(ErrorCode::kBadCamera,
                   "the camera " + Short(name) + " has " + std::to_string(camera.width) + "x" +
                       std::to_string(camera.height) + " pixels, the image has " +
                       std::to_string(image.width) + "x" + std::to_string(image.height) +
                       "; send the image unscaled, or send fx, fy, cx and cy");
  }
  return camera;
}

}  // namespace

void RequestLimits::Check() const {
  if (max_images < 1 || max_images > 64 || max_deadline_ms < 1) {
    throw MapError(ErrorCode::kBadOptions,
                   "max_images must be between 1 and 64, and max_deadline_ms positive");
  }
}

LocalizeRequest ReadLocalizeRequest(const HttpRequest& request, const RequestLimits& limits) {
  const std::string given = request.header("Content-Type").value_or("");
  const std::string type = MediaTypeOf(given);
  if (type == "multipart/form-data") return ReadForm(request, given, limits);
  if (type == "application/json") return ReadJson(request, limits);
  // A form is what curl calls any body when it isn't told otherwise, so a photo sent the shortest
  // way comes as one.
  const bool raw = type.empty() || type.starts_with("image/") ||
                   type == "application/octet-stream" ||
                   type == "application/x-www-form-urlencoded";
  if (raw) return ReadRaw(request, limits);
  throw MapError(ErrorCode::kUnsupportedMedia,
                 Short(type) +
                     " is not supported; send the image file as image/jpeg, image/png, "
                     "multipart/form-data or JSON");
}

Json RequestObject(const LocalizeRequest& request) {
  Json json = Json::object();
  if (request.intrinsics) {
    json["fx"] = request.intrinsics->fx;
    json["fy"] = request.intrinsics->fy;
    json["cx"] = request.intrinsics->cx;
    json["cy"] = request.intrinsics->cy;
  }
  if (request.fov_rad) json["fov_deg"] = *request.fov_rad / kDegree;
  if (request.stored_camera) json["camera"] = *request.stored_camera;
  if (request.prior_keyframe) json["prior"] = {{"keyframe", *request.prior_keyframe}};
  if (!request.previous.is_null()) json["previous"] = request.previous;
  for (const std::optional<Pose2>& motion : request.odometry) {
    json["odometry"].push_back(
        motion ? Json{{"x", motion->x}, {"y", motion->y}, {"heading_rad", motion->theta_rad}}
               : Json(nullptr));
  }
  if (request.top_k) json["top_k"] = *request.top_k;
  if (request.debug) json["debug"] = true;
  if (request.deadline_ms) json["deadline_ms"] = *request.deadline_ms;
  return json;
}

LocalizeRequest ParseRequestObject(const Json& object, const RequestLimits& limits) {
  return ReadObject(object, limits, false);
}

std::optional<Camera> CameraOf(const LocalizeRequest& request, const MapData& map,
                               const ImageHeader& image) {
  if (request.stored_camera) return StoredCamera(map, *request.stored_camera, image);
  Camera camera{CameraModel::kPinhole, image.width, image.height, {}};
  if (request.intrinsics) {
    const Intrinsics& k = *request.intrinsics;
    camera.params = {k.fx, k.fy, k.cx, k.cy};
    return camera;
  }
  if (!request.fov_rad) return std::nullopt;
  const double f = image.width / 2.0 / std::tan(*request.fov_rad / 2);
  camera.params = {f, f, (image.width - 1) / 2.0, (image.height - 1) / 2.0};
  return camera;
}

std::optional<Camera> CameraByExif(const QueryImage& image) {
  const auto* bytes = reinterpret_cast<const uint8_t*>(image.bytes.data());
  const std::optional<ExifCamera> exif = ReadExifCamera({bytes, image.bytes.size()});
  if (!exif) return std::nullopt;
  return Camera{
      CameraModel::kPinhole,
      exif->width,
      exif->height,
      {exif->focal_px, exif->focal_px, (exif->width - 1) / 2.0, (exif->height - 1) / 2.0}};
}

std::optional<Camera> CameraFor(const LocalizeRequest& request, const MapData& map,
                                const QueryImage& image) {
  const bool given = request.intrinsics || request.fov_rad || request.stored_camera;
  if (!given) return CameraByExif(image);
  const auto* bytes = reinterpret_cast<const uint8_t*>(image.bytes.data());
  try {
    return CameraOf(request, map, ReadImageHeader({bytes, image.bytes.size()}));
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage) throw;
    return std::nullopt;
  }
}

}  // namespace waystone
