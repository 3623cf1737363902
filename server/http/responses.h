// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "api/json.h"
#include "server/http/message.h"

namespace waystone {

// 200 with one line of JSON.
inline HttpResponse JsonResponse(const Json& json) {
  return {200, "application/json", Dump(json) + "\n", {}};
}

// The value of a query parameter; `fallback` when it isn't there.
inline std::string ParameterOf(const HttpRequest& request, const std::string& name,
                               const std::string& fallback) {
  const auto it = request.query.find(name);
  return it == request.query.end() ? fallback : it->second;
}

// Whether the client has the version with this entity tag already (If-None-Match of RFC 9110,
// section 13.1.2: a list of tags, or "*").
inline bool IsKnown(const HttpRequest& request, const std::string& etag) {
  const std::string tags = request.header("If-None-Match").value_or("");
  return tags == "*" || tags.find(etag) != std::string::npos;
}

}  // namespace waystone
