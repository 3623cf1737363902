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

// A request whose bytes have all arrived. Inside server/http only.
struct ReceivedRequest {
  std::string head;  // request line and headers, without those of the body's framing
  std::string method;
  std::string target;               // percent-encoded, from the path on
  std::optional<std::string> host;  // that was asked
  HttpHeaders headers;
  std::string body;
  std::string remote;                  // the client's address
  Clock::time_point received;          // when the last byte was
  bool close = false;                  // the connection is closed after the answer
  std::optional<MapError> refusal;     // the answer, instead of what the application says
  std::optional<MapError> body_error;  // what whoever reads the body is told
};

struct SentResponse {
  std::string bytes;
  bool close = false;
};

// From the bytes of a request to those of its answer. The HTTP library parses the headers and
// writes the answer; it never sees a socket, a target or a body. Compression and ranges, which a
// server may leave undone, are: the library takes the slowest setting of the first, and applies the
// second to errors too, as often as it is asked.
class HttpEngine {
 public:
  using Dispatch = std::function<HttpResponse(const HttpRequest&)>;

  // Of a server that listens on `port`; `keep_alive_s` is told to clients.
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
