// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"

// The head of a request: its request line and headers. Inside server/http only.
namespace waystone {

// Bounds of what a stranger may send before anything is known of the request.
constexpr size_t kMaxRequestLineBytes = 8192;
constexpr size_t kMaxHeaderLineBytes = 8192;  // the HTTP library takes no longer ones
constexpr size_t kMaxHeadBytes = 65'536;
constexpr int kMaxHeaders = 100;

// Finds the end of the head in bytes that arrive piece by piece; each byte is looked at once.
class HeadScanner {
 public:
  // Takes all bytes received so far, the request line first. Returns the size of the head with its
  // empty line, or nothing while that hasn't come. Throws MapError: kHeadTooLarge over one of the
  // bounds, kBadRequest for a zero byte, a CR alone or a line that doesn't end with CR LF.
  std::optional<size_t> Scan(std::string_view bytes);

 private:
  void CheckLine(std::string_view line, size_t bound) const;

  size_t line_start_ = 0;
  size_t scanned_ = 0;
  int lines_ = 0;
};

// What the transport has to know of a request before its body is read.
struct RequestHead {
  // For the HTTP library: without the headers of the body's framing, and without Range, which the
  // library would judge before anybody is asked.
  std::string text;
  std::string method;               // empty where the request line can't be read
  std::string target;               // percent-encoded, from the path's '/' on
  std::optional<std::string> host;  // that was asked: the target's, else the header's
  bool is_post = false;
  bool is_urgent = false;         // a health check
  bool expects_continue = false;  // the client sends the body once it is told to
  bool chunked = false;
  int64_t body_bytes = 0;  // where not chunked
  bool close = false;      // the client wants no other request on the connection
  std::string authorization;
  // As they came, in their order; without those of the body's framing, and without Range.
  std::vector<std::pair<std::string, std::string>> headers;
  // Why it is refused before its body is read; the connection can't be used any further then,
  // because nobody knows where the next request begins.
  std::optional<MapError> refusal;

  bool has_body() const { return chunked || body_bytes > 0; }
};

// Reads a complete head. What could be read in two ways (repeated, contradicting or malformed
// lengths, continued lines, a space before a colon, codings but "chunked", two headers Host, none
// in HTTP/1.1, a name of a header that is none, codings in HTTP/1.0) is refused, and so are encoded
// bodies and bodies of other methods than POST. A target is a path, or a whole URL (RFC 9112,
// section 3.2.2); OPTIONS may ask for "*". Pure.
RequestHead ParseRequestHead(std::string_view bytes);

}  // namespace waystone
