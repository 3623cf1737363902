// SPDX-License-Identifier: Apache-2.0
#include "server/service/localize_request.h"

#include <map>

#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

// "a=b&c=d".
std::map<std::string, std::string> QueryParameters(std::string_view text) {
  std::map<std::string, std::string> parameters;
  while (!text.empty()) {
    const std::string_view one = text.substr(0, text.find('&'));
    text.remove_prefix(std::min(one.size() + 1, text.size()));
    const size_t equals = std::min(one.find('='), one.size());
    parameters.emplace(one.substr(0, equals), one.substr(std::min(equals + 1, one.size())));
  }
  return parameters;
}

}  // namespace

// The input is the header Content-Type, a line of query parameters, and the body. What is asked is
// within the limits, and what the query log keeps of it is read again.
bool FuzzLocalizeRequest(FuzzInput input) {
  const auto [type, behind_type] = SplitLine(input);
  const auto [query, body] = SplitLine(behind_type);
  HttpRequest http;
  http.method = "POST";
  http.query = QueryParameters(query);
  http.header = [content_type = std::string(type)](const std::string& name) {
    return name == "Content-Type" ? std::optional(content_type) : std::nullopt;
  };
  http.read_body = [bytes = std::string(TextOf(body))] { return bytes; };
  const RequestLimits limits;
  const auto request = ReadOrRefuse([&] { return ReadQueryRequest(http, limits); });
  if (!request) return false;
  const size_t images = request->images.size();
  Require(images >= 1 && images <= static_cast<size_t>(limits.max_images),
          "a request has one to the most images");
  Require(request->odometry.empty() || request->odometry.size() == images,
          "a motion for each image");
  for (const QueryImage& image : request->images) {
    Require(image.name.size() <= kMaxNameBytes, "names are short");
    Require(image.bytes.size() <= body.size(), "an image is no longer than the body");
  }
  const Json written = ToJson(*request);
  ReadBack([&] { return ParseQueryRequest(written, limits); }, Dump(written));
  return true;
}

}  // namespace waystone
