// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/query_request_json.h"
#include "localizer/query.h"
#include "server/http/message.h"

namespace waystone {

// Reads a request's body by its Content-Type:
//   image/*, application/octet-stream, application/x-www-form-urlencoded (what curl sends
//   by default), none: the image; the rest as query parameters;
//   multipart/form-data: parts `image` (one or more) and `request`, a JSON object;
//   application/json: the same object with "images": [{"name", "data": base64}].
// Throws what read_body throws, and MapError: kUnsupportedMedia, and kBadRequest, naming the field,
// for one that is unknown, out of range or contradicts another. Thread-safe.
QueryRequest ReadQueryRequest(const HttpRequest& request, const RequestLimits& limits);

// Whether the body is JSON.
bool IsJson(const HttpRequest& request);

}  // namespace waystone
