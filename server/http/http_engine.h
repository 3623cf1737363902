// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "core/base/error.h"
#include "server/http/message.h"

namespace waystone {

// A request whose bytes have all arrived. Internal to server/http.
struct ReceivedRequest {
  std::string head;  // request line and headers, without those of the body's framing
  std::string method;
  std::string target;               // percent-encoded, from the path on
  std::optional<std::string> host;  // the host asked for
  HttpHeaders headers;
  std::string body;
  std::string remote;                  // the client's address
  Clock::time_point received;          // when the last byte arrived
  bool close = false;                  // the connection is closed after the answer
  std::optional<MapError> refusal;     // the answer, instead of the application's
  std::optional<MapError> body_error;  // thrown to whoever reads the body
};

struct SentResponse {
  std::string bytes;
  bool close = false;
};

// Turns the bytes of a request into those of its answer. The HTTP library parses the headers and
// writes the answer; it never sees a socket, a target or a body. Compression and ranges are
// optional in HTTP, and are left out: the library uses the slowest setting of the former, and
// applies the latter even to errors, as often as asked.
class HttpEngine {
 public:
  using Dispatch = std::function<HttpResponse(const HttpRequest&)>;

  // For a server that listens on `port`; clients are told `keep_alive_s`.
  HttpEngine(Dispatch dispatch, int port, int keep_alive_s);
  ~HttpEngine();
  HttpEngine(const HttpEngine&) = delete;
  HttpEngine& operator=(const HttpEngine&) = delete;

  // Thread-safe. Throws nothing but std::bad_alloc.
  SentResponse Answer(ReceivedRequest request);

 private:
  class Library;
  std::unique_ptr<Library> library_;
};

}  // namespace waystone
