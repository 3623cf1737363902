// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"

// The head of a request: its request line and headers. Internal to server/http.
namespace waystone {

// Bounds on what a stranger may send before anything is known of the request.
constexpr size_t kMaxRequestLineBytes = 8192;
constexpr size_t kMaxHeaderLineBytes = 8192;  // the HTTP library accepts no longer ones
constexpr size_t kMaxHeadBytes = 65'536;
constexpr int kMaxHeaders = 100;

// Finds the end of a head whose bytes arrive piece by piece; looks at each byte once. Not
// thread-safe.
class HeadScanner {
 public:
  // Takes all bytes received so far, starting with the request line. Returns the size of the head,
  // including its empty line, or nothing until that has arrived. Throws MapError: kHeadTooLarge
  // over one of the bounds, kBadRequest for a zero byte, a bare CR, or a line that doesn't end with
  // CR LF.
  std::optional<size_t> Scan(std::string_view bytes);

 private:
  void CheckLine(std::string_view line, size_t bound) const;

  size_t line_start_ = 0;
  size_t scanned_ = 0;
  int lines_ = 0;
};

// What the transport has to know of a request before its body is read.
struct RequestHead {
  // For the HTTP library: without the headers that frame the body, and without Range, which the
  // library would judge before any handler sees it.
  std::string text;
  std::string method;               // empty where the request line can't be read
  std::string target;               // percent-encoded, from the path's '/' on
  std::optional<std::string> host;  // the host asked for: the target's, else the header's
  bool is_post = false;
  bool is_urgent = false;         // a health check
  bool expects_continue = false;  // the client sends the body once it is told to
  bool chunked = false;
  int64_t body_bytes = 0;  // where not chunked
  bool close = false;      // the client sends no other request on the connection
  std::string authorization;
  // As they came, in order, without those that frame the body, and without Range.
  std::vector<std::pair<std::string, std::string>> headers;
  // Why the request is refused before its body is read; the connection can't be used any further
  // then, because nobody knows where the next request begins.
  std::optional<MapError> refusal;

  bool has_body() const { return chunked || body_bytes > 0; }
};

// Parses a complete head. Refuses anything that could be read in two ways (repeated, contradictory
// or malformed lengths, folded lines, a space before a colon, transfer codings other than
// "chunked", any in HTTP/1.0, two Host headers, none in HTTP/1.1, an invalid header name), and also
// encoded bodies and bodies of methods other than POST. A target is a path, or a whole URL (RFC
// 9112, section 3.2.2); OPTIONS may ask for "*". Pure; thread-safe.
RequestHead ParseRequestHead(std::string_view bytes);

}  // namespace waystone
