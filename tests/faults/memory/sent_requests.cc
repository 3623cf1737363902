// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/memory/sent_requests.h"

#include <array>
#include <cstdint>
#include <optional>

#include "tests/faults/memory/made_places.h"

namespace waystone {
namespace {

constexpr const char* kPhotos = "/v1/maps/photos/localize";
constexpr const char* kPanoramas = "/v1/maps/panoramas/localize";

std::string Base64(const std::string& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t value = 0;
    for (size_t j = 0; j < 3; ++j) {
      value = value << 8 | (i + j < bytes.size() ? static_cast<uint8_t>(bytes[i + j]) : 0);
    }
    for (int digit = 0; digit < 4; ++digit) text += kDigits[value >> (18 - 6 * digit) & 63];
  }
  const size_t padding = (3 - bytes.size() % 3) % 3;
  return text.replace(text.size() - padding, padding, padding, '=');
}

std::string JsonBody(const std::string& image, const std::string& more) {
  return R"({"images": [{"name": "a.jpg", "data": ")" + Base64(image) + "\"}]" + more + "}";
}

std::string Part(const std::string& disposition, const std::string& bytes) {
  return "--edge\r\nContent-Disposition: form-data; " + disposition + "\r\n\r\n" + bytes + "\r\n";
}

std::string Form() {
  return Part("name=\"request\"", R"({"top_k": 3, "debug": true})") +
         Part("name=\"image\"; filename=\"a.jpg\"", PhotoJpeg()) +
         Part("name=\"image\"; filename=\"b.jpg\"", PhotoJpeg()) + "--edge--\r\n";
}

}  // namespace

HttpRequest SentRequest::ToRequest() const {
  HttpRequest request;
  request.method = method;
  request.path = path;
  request.header = [this](const std::string& header) -> std::optional<std::string> {
    if (header == "Content-Type" && !type.empty()) return type;
    return std::nullopt;
  };
  request.read_body = [this] { return body; };
  return request;
}

std::vector<SentRequest> SentRequests() {
  const std::string json = "application/json";
  return {
      {"photo", "POST", kPhotos, "image/jpeg", PhotoJpeg()},
      {"panorama", "POST", kPanoramas, "image/jpeg", PanoramaJpeg()},
      {"photo_of_panoramas", "POST", kPanoramas, json, JsonBody(PhotoJpeg(), R"(, "fov_deg": 68)")},
      {"form", "POST", kPhotos, "multipart/form-data; boundary=edge", Form()},
      {"all_maps", "POST", "/v1/localize", json, JsonBody(PhotoJpeg(), "")},
      {"bad_image", "POST", kPhotos, "image/jpeg", PhotoJpeg().substr(0, 600)},
      {"bad_json", "POST", kPhotos, json, R"({"images": [[{"a": [1, 2, {"b": [3]}]}], 1})", 400},
      {"unknown_field", "POST", kPhotos, json, R"({"images": [[1], {"a": [2]}], "x": 1})", 400},
      {"no_map", "POST", "/v1/maps/none/localize", "image/jpeg", PhotoJpeg(), 404},
      {"maps", "GET", "/v1/maps", "", ""},
      {"overview", "GET", "/v1/maps/photos/overview", "", ""},
      {"appearance", "GET", "/v1/maps/panoramas/appearance", "", ""},
      {"metrics", "GET", "/metrics", "", ""}};
}

std::string PhotoQuery(const std::string& parameters) {
  return "POST " + (kPhotos + parameters) +
         " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: image/jpeg\r\n"
         "Content-Length: " +
         std::to_string(PhotoJpeg().size()) + "\r\n\r\n" + PhotoJpeg();
}

}  // namespace waystone
