// SPDX-License-Identifier: Apache-2.0
#include "server/http/request_head.h"

#include <strings.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "core/base/text.h"

namespace waystone {
namespace {

constexpr std::string_view kLineEnd = "\r\n";
constexpr std::string_view kSpace = " \t";  // OWS of RFC 9110

bool EqualsIgnoringCase(std::string_view a, std::string_view b) {
  return a.size() == b.size() && strncasecmp(a.data(), b.data(), a.size()) == 0;
}

// Digits only, and few enough not to overflow.
std::optional<int64_t> ParseLength(std::string_view text) {
  int64_t length = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  const bool digits =
      std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (text.empty() || !digits || error != std::errc() || end != text.data() + text.size())
    return {};
  return length;
}

// Whether it is a token of RFC 9110, as methods and names of headers are.
bool IsHttpToken(std::string_view text) {
  constexpr std::string_view kSigns = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || kSigns.find(c) != kSigns.npos;
  });
}

bool HasControlOrSpace(std::string_view text) {
  return std::ranges::any_of(text, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte <= ' ' || byte == 0x7F;
  });
}

// Collects what the headers say of the body.
class HeadParser {
 public:
  void RequestLine(std::string_view line) {
    Keep(line);
    const std::string_view method = line.substr(0, line.find(' '));
    const std::string_view version = line.substr(std::min(line.rfind(' '), line.size() - 1) + 1);
    std::string_view target = line.substr(std::min(method.size() + 1, line.size()));
    target.remove_suffix(std::min(version.size() + 1, target.size()));
    is_http11_ = version == "HTTP/1.1";
    if (!IsHttpToken(method) || !ReadTarget(method, target) ||
        (!is_http11_ && version != "HTTP/1.0")) {
      return Refuse(ErrorCode::kBadRequest,
                    "malformed HTTP request line; expected METHOD /PATH HTTP/1.1");
    }
    head_.method = method;
    head_.is_post = method == "POST";
    const std::string path = head_.target.substr(0, head_.target.find_first_of("?#"));
    head_.is_urgent = path == "/healthz" || path == "/readyz";
    with_body_ = head_.is_post ? "" : head_.method + " requests must not have a body";
  }

  void Header(std::string_view line) {
    const size_t colon = line.find(':');
    const std::string_view name = line.substr(0, colon);
    if (colon == std::string_view::npos || !IsHttpToken(name)) {
      return Refuse(ErrorCode::kBadRequest, "malformed header in the HTTP request");
    }
    const std::string_view value = Trimmed(line.substr(colon + 1), kSpace);
    if (EqualsIgnoringCase(name, "Content-Length")) return ContentLength(value);
    if (EqualsIgnoringCase(name, "Transfer-Encoding")) return TransferEncoding(value);
    if (EqualsIgnoringCase(name, "Expect")) return Expect(value);
    if (EqualsIgnoringCase(name, "Content-Encoding")) {
      Refuse(ErrorCode::kUnsupportedMedia,
             "encoded bodies are not supported; send the image without Content-Encoding");
    }
    if (EqualsIgnoringCase(name, "Range")) return;
    if (EqualsIgnoringCase(name, "Host")) {
      ++hosts_;
      if (!head_.host) head_.host = value;
    }
    if (EqualsIgnoringCase(name, "Authorization")) head_.authorization = value;
    if (EqualsIgnoringCase(name, "Connection")) Connection(value);
    head_.headers.emplace_back(name, value);
    Keep(line);
  }

  RequestHead Finish() {
    if (!is_http11_ && head_.chunked) {  // RFC 9112, section 6.1
      Refuse(ErrorCode::kBadRequest, "HTTP/1.0 has no Transfer-Encoding; send HTTP/1.1");
    }
    if (!is_http11_) head_.expects_continue = false;
    head_.close |= !is_http11_ && !keep_alive_;
    if (lengths_ > 1 || (lengths_ == 1 && head_.chunked)) {
      Refuse(ErrorCode::kBadRequest, "the length of the body is given twice");
    }
    if (hosts_ > 1 || (hosts_ == 0 && is_http11_)) {
      Refuse(ErrorCode::kBadRequest, "an HTTP/1.1 request requires exactly one Host header");
    }
    if (head_.has_body() && !head_.is_post) Refuse(ErrorCode::kBadRequest, with_body_);
    head_.text += kLineEnd;
    return std::move(head_);
  }

 private:
  // A path, or a URL, whose host then overrides the Host header.
  bool ReadTarget(std::string_view method, std::string_view target) {
    if (target.empty() || HasControlOrSpace(target)) return false;
    for (const std::string_view scheme : {"http://", "https://"}) {
      if (!EqualsIgnoringCase(target.substr(0, scheme.size()), scheme)) continue;
      target.remove_prefix(scheme.size());
      head_.host = target.substr(0, target.find_first_of("/?#"));
      target.remove_prefix(head_.host->size());
      head_.target = target.starts_with('/') ? "" : "/";
      head_.target += target;
      return !head_.host->empty();
    }
    head_.target = target;
    return target.starts_with('/') || (target == "*" && method == "OPTIONS");
  }

  void Keep(std::string_view line) {
    head_.text += line;
    head_.text += kLineEnd;
  }

  // The first reason is the one reported.
  void Refuse(ErrorCode code, const std::string& detail) {
    if (!head_.refusal) head_.refusal.emplace(code, detail);
  }

  void ContentLength(std::string_view value) {
    ++lengths_;
    const std::optional<int64_t> length = ParseLength(value);
    if (!length) Refuse(ErrorCode::kBadRequest, "Content-Length is not a number");
    head_.body_bytes = length.value_or(0);
  }

  void TransferEncoding(std::string_view value) {
    if (head_.chunked || !EqualsIgnoringCase(value, "chunked")) {
      Refuse(ErrorCode::kBadRequest, "the only supported Transfer-Encoding is chunked");
    }
    head_.chunked = true;
  }

  // A list (RFC 9110, section 7.6.1).
  void Connection(std::string_view value) {
    while (!value.empty()) {
      const size_t comma = std::min(value.find(','), value.size());
      const std::string_view option = Trimmed(value.substr(0, comma), kSpace);
      head_.close |= EqualsIgnoringCase(option, "close");
      keep_alive_ |= EqualsIgnoringCase(option, "keep-alive");
      value.remove_prefix(std::min(comma + 1, value.size()));
    }
  }

  void Expect(std::string_view value) {
    head_.expects_continue = EqualsIgnoringCase(value, "100-continue");
    if (!head_.expects_continue) {
      Refuse(ErrorCode::kBadRequest, "the only supported expectation is 100-continue");
    }
  }

  RequestHead head_;
  int lengths_ = 0;
  int hosts_ = 0;
  bool is_http11_ = false;   // which requires a Host (RFC 9112, section 3.2)
  bool keep_alive_ = false;  // without it, connections of HTTP/1.0 close (RFC 9112, section 9.3)
  std::string with_body_;
};

}  // namespace

void HeadScanner::CheckLine(std::string_view line, size_t bound) const {
  if (line.size() > bound) {
    throw MapError(ErrorCode::kHeadTooLarge,
                   "a line of the request's head exceeds " + std::to_string(bound) + " bytes");
  }
}

std::optional<size_t> HeadScanner::Scan(std::string_view bytes) {
  const auto bound = [this] { return lines_ == 0 ? kMaxRequestLineBytes : kMaxHeaderLineBytes; };
  for (; scanned_ < bytes.size(); ++scanned_) {
    if (scanned_ >= kMaxHeadBytes) {
      throw MapError(ErrorCode::kHeadTooLarge,
                     "the request's headers exceed " + std::to_string(kMaxHeadBytes) + " bytes");
    }
    const char c = bytes[scanned_];
    if (c == '\0') throw MapError(ErrorCode::kBadRequest, "malformed HTTP request");
    if (c != '\n') {
      // Where readers disagree on the end of a line, headers can be smuggled in.
      if (scanned_ > line_start_ && bytes[scanned_ - 1] == '\r') {
        throw MapError(ErrorCode::kBadRequest, "malformed HTTP request: a CR without LF");
      }
      continue;
    }
    const std::string_view line = bytes.substr(line_start_, scanned_ + 1 - line_start_);
    if (!line.ends_with(kLineEnd)) {
      throw MapError(ErrorCode::kBadRequest, "malformed HTTP request: a line ends without CR LF");
    }
    CheckLine(line, bound());
    line_start_ = scanned_ + 1;
    if (line == kLineEnd) return ++scanned_;
    if (++lines_ > kMaxHeaders + 1) {
      throw MapError(ErrorCode::kHeadTooLarge,
                     "the request has more than " + std::to_string(kMaxHeaders) + " headers");
    }
  }
  CheckLine(bytes.substr(line_start_), bound());
  return std::nullopt;
}

RequestHead ParseRequestHead(std::string_view bytes) {
  HeadParser parser;
  bool first = true;
  while (!bytes.empty()) {
    const std::string_view line = bytes.substr(0, bytes.find(kLineEnd));
    bytes.remove_prefix(std::min(bytes.size(), line.size() + kLineEnd.size()));
    if (line.empty()) break;
    if (first) {
      parser.RequestLine(line);
    } else {
      parser.Header(line);
    }
    first = false;
  }
  if (first) parser.RequestLine("");
  return parser.Finish();
}

}  // namespace waystone
