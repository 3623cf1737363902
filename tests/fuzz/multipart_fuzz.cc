// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "server/http/body_parts.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

constexpr size_t kMaxParts = 9;

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += {'\\', c};
  return escaped;
}

// A boundary that is in none of the parts.
std::string UnusedBoundary(const std::vector<BodyPart>& parts) {
  for (int i = 0;; ++i) {
    std::string boundary = "x" + std::to_string(i);
    const bool used = std::ranges::any_of(parts, [&](const BodyPart& part) {
      return part.bytes.find(boundary) != std::string_view::npos;
    });
    if (!used) return boundary;
  }
}

std::string WriteForm(const std::vector<BodyPart>& parts, const std::string& boundary) {
  std::string form;
  for (const BodyPart& part : parts) {
    form += "--" + boundary + "\r\nContent-Disposition: form-data; name=\"" + Escaped(part.name) +
            "\"; filename=\"" + Escaped(part.filename) + "\"\r\n\r\n";
    form += part.bytes;
    form += "\r\n";
  }
  return form + "--" + boundary + "--\r\n";
}

bool SamePart(const BodyPart& a, const BodyPart& b) {
  return a.name == b.name && a.filename == b.filename && a.bytes == b.bytes;
}

}  // namespace

// The input is the header Content-Type, and from the second line on the body. Parts lie within it,
// and a form written from them has the same parts.
bool FuzzMultipart(FuzzInput input) {
  const auto [type, rest] = SplitLine(input);
  const std::string_view body = TextOf(rest);
  const std::string content_type(type);
  const auto parts = ReadOrRefuse([&] { return ParseMultipart(body, content_type, kMaxParts); });
  if (!parts) return false;
  Require(parts->size() <= kMaxParts, "a form has no more parts than allowed");
  size_t names = 0;
  for (const BodyPart& part : *parts) {
    const bool inside =
        part.bytes.empty() || (part.bytes.data() >= body.data() &&
                               part.bytes.data() + part.bytes.size() <= body.data() + body.size());
    Require(inside, "a part's bytes lie within the body");
    Require(!part.name.empty(), "a part has a name");
    names = std::max(names, part.name.size() + part.filename.size());
  }
  constexpr size_t kMostEscaped = 2000;  // their headers are bounded
  if (names > kMostEscaped || parts->empty()) return true;
  const std::string boundary = UnusedBoundary(*parts);
  const std::string written = WriteForm(*parts, boundary);
  const auto again = ReadBack(
      [&] {
        return ParseMultipart(written, "multipart/form-data; boundary=" + boundary, kMaxParts);
      },
      "a form");
  Require(std::ranges::equal(*parts, again, SamePart), "a form is written and read to the same");
  return true;
}

}  // namespace waystone
