// SPDX-License-Identifier: Apache-2.0
#include "server/http/body_parts.h"

#include <openssl/evp.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr size_t kMaxBoundary = 70;         // characters, RFC 2046
constexpr size_t kMaxPartHeaders = 4096;    // bytes of one part's headers
constexpr size_t kMaxDataUrlPrefix = 100;   // bytes of "data:image/jpeg;base64,"
constexpr size_t kMaxDecodable = 1U << 30;  // OpenSSL counts in int
constexpr std::string_view kBlanks = " \t";

[[noreturn]] void RefuseBody(const std::string& cause) {
  throw MapError(ErrorCode::kBadRequest, cause);
}

std::string Lower(std::string_view text) {
  std::string lower;
  for (const char c : text) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

// The value of `name` among parameters like `form-data; name="image"; filename=a.jpg`.
std::optional<std::string> Parameter(std::string_view text, const std::string& name) {
  size_t at = text.find(';');
  while (at != std::string_view::npos) {
    ++at;
    at = std::min(text.find_first_not_of(kBlanks, at), text.size());
    const size_t equals = text.find('=', at);
    if (equals == std::string_view::npos) return std::nullopt;
    const std::string key = Lower(text.substr(at, equals - at));
    std::string value;
    at = equals + 1;
    if (at < text.size() && text[at] == '"') {
      for (++at; at < text.size() && text[at] != '"'; ++at) {
        if (text[at] == '\\' && at + 1 < text.size()) ++at;
        value += text[at];
      }
    } else {
      const size_t end = std::min(text.find_first_of("; \t", at), text.size());
      value = text.substr(at, end - at);
      at = end;
    }
    if (key == name) return value;
    at = text.find(';', at);
  }
  return std::nullopt;
}

std::string BoundaryOf(const std::string& content_type) {
  std::string boundary = Parameter(content_type, "boundary").value_or("");
  if (boundary.empty() || boundary.size() > kMaxBoundary) {
    RefuseBody("multipart/form-data without a boundary; let the HTTP library set Content-Type");
  }
  return boundary;
}

// Lines that continue the one before (RFC 5322, section 2.2.3) become part of it.
std::string Unfolded(std::string_view headers) {
  std::string text(headers);
  for (size_t at = text.find("\r\n"); at != std::string::npos; at = text.find("\r\n", at + 2)) {
    const bool folded = at + 2 < text.size() && kBlanks.find(text[at + 2]) != kBlanks.npos;
    if (folded) text.replace(at, 2, "  ");
  }
  return text;
}

// A part from its headers on, up to the next boundary.
BodyPart ParsePart(std::string_view text) {
  const size_t end = text.starts_with("\r\n") ? 0 : text.find("\r\n\r\n");
  if (end > kMaxPartHeaders) {  // or npos
    RefuseBody("a part of the form has no headers; each part requires Content-Disposition");
  }
  BodyPart part;
  const std::string unfolded = Unfolded(text.substr(0, end));
  std::string_view headers = unfolded;
  part.bytes = text.substr(end == 0 ? 2 : end + 4);
  while (!headers.empty()) {
    const size_t line_end = std::min(headers.find("\r\n"), headers.size());
    const std::string_view line = headers.substr(0, line_end);
    headers.remove_prefix(std::min(headers.size(), line_end + 2));
    if (!Lower(line.substr(0, 20)).starts_with("content-disposition:")) continue;
    part.name = Parameter(line, "name").value_or("");
    part.filename = Parameter(line, "filename").value_or("");
  }
  if (part.name.empty())
    RefuseBody("a part of the form has no name; it must be 'image' or 'request'");
  return part;
}

// The position after the first boundary. Text may precede it (RFC 2046, section 5.1.1).
size_t FindFirstPart(std::string_view body, const std::string& delimiter) {
  if (body.starts_with(delimiter)) return delimiter.size();
  const std::string line = "\r\n" + delimiter;
  const size_t start = body.find(line);
  if (start == std::string_view::npos) RefuseBody("the form does not contain its boundary");
  return start + line.size();
}

}  // namespace

std::string MediaTypeOf(const std::string& content_type) {
  return Lower(content_type.substr(0, content_type.find_first_of("; ")));
}

std::vector<BodyPart> ParseMultipart(std::string_view body, const std::string& content_type,
                                     size_t max_parts) {
  const std::string delimiter = "--" + BoundaryOf(content_type);
  const std::string next = "\r\n" + delimiter;
  std::vector<BodyPart> parts;
  size_t at = FindFirstPart(body, delimiter);
  while (!body.substr(at).starts_with("--")) {
    // Mail may have padded the line.
    at = std::min(body.find_first_not_of(kBlanks, at), body.size());
    if (!body.substr(at).starts_with("\r\n"))
      RefuseBody("the form has extra characters after a boundary");
    const size_t end = body.find(next, at);
    if (end == std::string_view::npos) RefuseBody("the form ends before its final boundary");
    if (parts.size() == max_parts) {
      RefuseBody("the form has more than " + std::to_string(max_parts) +
                 " parts; send fewer images");
    }
    // In an empty part, the end of the blank line is the beginning of the boundary.
    const size_t begin = std::min(at + 2, end);
    parts.push_back(ParsePart(body.substr(begin, end - begin)));
    at = end + next.size();
  }
  return parts;
}

std::string DecodeBase64(std::string_view text) {
  if (text.starts_with("data:")) {
    const size_t comma = text.substr(0, kMaxDataUrlPrefix).find(";base64,");
    if (comma == std::string_view::npos) RefuseBody("the data: URL is not base64");
    text.remove_prefix(comma + 8);
  }
  if (text.size() % 4 != 0 || text.size() > kMaxDecodable) {
    RefuseBody("base64 of " + std::to_string(text.size()) +
               " characters, not a multiple of 4; keep the padding and remove line breaks");
  }
  const size_t padding = text.ends_with("==") ? 2 : text.ends_with("=") ? 1 : 0;
  const std::string_view digits = text.substr(0, text.size() - padding);
  for (const char c : digits) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '+' && c != '/') {
      RefuseBody("the image data is not base64: it has characters other than A-Z a-z 0-9 + /");
    }
  }
  std::string bytes(text.size() / 4 * 3, '\0');
  const int count = EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                                    reinterpret_cast<const unsigned char*>(text.data()),
                                    static_cast<int>(text.size()));
  if (count < 0) RefuseBody("the image data is not base64");
  bytes.resize(bytes.size() - padding);
  return bytes;
}

}  // namespace waystone
