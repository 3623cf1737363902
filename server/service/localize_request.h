// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/query_request_json.h"
#include "localizer/query.h"
#include "server/http/message.h"

namespace waystone {

// Reads a request's body by its Content-Type:
//   image/*, application/octet-stream, none: the image; the rest as query parameters;
//   multipart/form-data: parts `image` (one or more) and `request`, a JSON object;
//   application/json: the same object with "images": [{"name", "data": base64}].
// Throws MapError: kUnsupportedMedia, kPayloadTooLarge, and kBadRequest with the field at fault for
// what is unknown, out of range or contradicts itself.
QueryRequest ReadQueryRequest(const HttpRequest& request, const RequestLimits& limits);

// Whether the body is JSON.
bool IsJson(const HttpRequest& request);

}  // namespace waystone
