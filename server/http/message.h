// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "core/base/error.h"

// A request and its response as handlers see them, whatever the HTTP library.
namespace waystone {

using HttpHeaders = std::vector<std::pair<std::string, std::string>>;  // in their order

struct HttpRequest {
  std::string method;  // "GET", "POST", ...
  std::string path;    // without the query, percent-decoded except for %2F and %25
  std::map<std::string, std::string> query;  // percent-decoded
  std::string id;      // names the request in logs: the client's X-Request-Id, or one of ours
  std::string remote;  // the client's address; empty when it isn't known
  int port = 0;        // our port, at which the request arrived
  Clock::time_point received = Clock::now();  // when its last byte arrived
  // The value of a header, whose name is matched in any case; nothing when it isn't there. Lines of
  // one name are joined with commas (RFC 9110, section 5.3).
  std::function<std::optional<std::string>(const std::string&)> header;
  // Reads the whole body; to be called at most once. Throws MapError: kPayloadTooLarge over the
  // server's limit, kBadRequest for a body that is malformed or ends early, kTooSlow, kBusy, and
  // kUnauthorized.
  std::function<std::string()> read_body;
  // The answer to a request that can't be read; method, path and headers may then be missing.
  std::optional<MapError> refusal = {};
};

struct HttpResponse {
  int status = 200;
  std::string content_type;
  std::string body;
  HttpHeaders headers;
  std::string route = {};  // the pattern whose handler answered, for logs; empty if none did
};

}  // namespace waystone
