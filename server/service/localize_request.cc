// SPDX-License-Identifier: Apache-2.0
#include "server/service/localize_request.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "server/http/body_parts.h"

namespace waystone {
namespace {

constexpr size_t kMaxObjectBytes = 65'536;  // of a form's part `request`

// A query parameter as the JSON that it stands for.
Json ParameterValue(const std::string& name, const std::string& text) {
  if (name == "camera") return text;
  if (name == "debug") {
    if (text == "true" || text == "1" || text.empty()) return true;
    if (text == "false" || text == "0") return false;
    RefuseRequest(QuoteShortened("debug=" + text) + " must be true or false");
  }
  Json value = Json::parse(text, nullptr, false);
  return value.is_number() ? value : Json(text);  // refused later, naming the field
}

void RefuseUnknown(const std::string& parameter) {
  constexpr std::array kKnown{"camera", "cx", "cy",   "deadline_ms",    "debug", "fov_deg",
                              "fx",     "fy", "name", "prior_keyframe", "top_k"};
  if (std::ranges::find(kKnown, parameter) != kKnown.end()) return;
  std::string known;
  for (const char* name : kKnown) known += (known.empty() ? "" : ", ") + std::string(name);
  RefuseRequest("unknown query parameter " + QuoteShortened(parameter) +
                "; known parameters: " + known);
}

QueryRequest ReadRaw(const HttpRequest& http, const RequestLimits& limits) {
  Json object = Json::object();
  QueryImage image{"query", ""};
  for (const auto& [name, text] : http.query) {
    if (name == "name") {
      image.name = NameIn(text, name);
    } else if (name == "prior_keyframe") {
      object["prior"]["keyframe"] = ParameterValue(name, text);
    } else if (name == "hints") {
      RefuseRequest("hints must be in a JSON body or a form's part 'request'");
    } else if (name == "prior" || name == "previous" || name == "odometry" || name == "images") {
      RefuseRequest(name + " must be in a JSON body; the query parameter is prior_keyframe");
    } else {
      RefuseUnknown(name);
      object[name] = ParameterValue(name, text);
    }
  }
  QueryRequest request = ParseQueryRequest(object, limits, false);
  image.bytes = http.read_body();
  request.images.push_back(std::move(image));
  return request;
}

void RefuseParameters(const HttpRequest& http) {
  if (http.query.empty()) return;
  RefuseRequest("with such a body, parameters must be in its JSON and not in the URL; move " +
                QuoteShortened(http.query.begin()->first));
}

void CheckCount(const QueryRequest& request, const RequestLimits& limits) {
  if (request.images.empty()) RefuseRequest("the body has no image");
  if (request.images.size() > static_cast<size_t>(limits.max_images)) {
    RefuseRequest(std::to_string(request.images.size()) + " images; the limit is " +
                  std::to_string(limits.max_images) + " per request");
  }
  CheckOdometry(request);
}

QueryRequest ReadForm(const HttpRequest& http, const std::string& type,
                      const RequestLimits& limits) {
  RefuseParameters(http);
  const std::string body = http.read_body();
  const size_t max_parts = static_cast<size_t>(limits.max_images) + 1;
  QueryRequest request;
  std::vector<QueryImage> images;
  bool described = false;
  for (const BodyPart& part : ParseMultipart(body, type, max_parts)) {
    if (part.name == "image") {
      const std::string name = part.filename.empty() ? "image " + std::to_string(images.size() + 1)
                                                     : part.filename.substr(0, kMaxNameBytes);
      images.push_back({name, std::string(part.bytes)});
    } else if (part.name == "request") {
      if (std::exchange(described, true))
        RefuseRequest("the form has more than one part 'request'");
      if (part.bytes.size() > kMaxObjectBytes) RefuseRequest("the part 'request' exceeds 64 KiB");
      request = ParseQueryRequest(ParseJson(part.bytes), limits, false);
    } else {
      RefuseRequest("the form has an unknown part " + QuoteShortened(part.name) +
                    "; known parts: 'image' and 'request'");
    }
  }
  request.images = std::move(images);
  CheckCount(request, limits);
  return request;
}

QueryRequest ReadJson(const HttpRequest& http, const RequestLimits& limits) {
  RefuseParameters(http);
  const Json object = ParseJson(http.read_body());
  QueryRequest request = ParseQueryRequest(object, limits, true);
  if (!object.contains("images") || !object["images"].is_array()) {
    RefuseRequest("images must be a list of {\"name\", \"data\": base64}");
  }
  for (const Json& image : object["images"]) {
    CheckKnownFields(image, "an image", {"data", "name"});
    if (!image.contains("data") || !image["data"].is_string()) {
      RefuseRequest("an image has no data; send its bytes as base64");
    }
    const std::string name = image.contains("name")
                                 ? NameIn(image["name"], "an image's name")
                                 : "image " + std::to_string(request.images.size() + 1);
    request.images.push_back({name, DecodeBase64(image["data"].get_ref<const std::string&>())});
    if (request.images.size() > static_cast<size_t>(limits.max_images)) break;
  }
  CheckCount(request, limits);
  return request;
}

}  // namespace

bool IsJson(const HttpRequest& request) {
  return MediaTypeOf(request.header("Content-Type").value_or("")) == "application/json";
}

QueryRequest ReadQueryRequest(const HttpRequest& request, const RequestLimits& limits) {
  const std::string given = request.header("Content-Type").value_or("");
  const std::string type = MediaTypeOf(given);
  if (type == "multipart/form-data") return ReadForm(request, given, limits);
  if (IsJson(request)) return ReadJson(request, limits);
  // curl calls any body a form unless told otherwise, so a photo sent in the shortest way arrives
  // as one.
  const bool raw = type.empty() || type.starts_with("image/") ||
                   type == "application/octet-stream" ||
                   type == "application/x-www-form-urlencoded";
  if (raw) return ReadRaw(request, limits);
  throw MapError(ErrorCode::kUnsupportedMedia,
                 QuoteShortened(type) +
                     " is not supported; send the image file as image/jpeg, image/png, "
                     "multipart/form-data or JSON");
}

}  // namespace waystone
