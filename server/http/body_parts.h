// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

// Bodies that hold several things, or bytes as text.
namespace waystone {

// "multipart/form-data" of "multipart/form-data; boundary=x": in small letters, no parameters.
std::string MediaTypeOf(const std::string& content_type);

struct BodyPart {
  std::string name;
  std::string filename;    // empty without one
  std::string_view bytes;  // of the body it was found in
};

// The parts of a multipart/form-data body (RFC 7578), in order. `content_type` is the header, with
// the boundary. Linear in the body's size, and copies none of it. Throws MapError(kBadRequest) for
// a body that is none and for more than `max_parts` parts.
std::vector<BodyPart> ParseMultipart(std::string_view body, const std::string& content_type,
                                     size_t max_parts);

// The bytes that base64 (RFC 4648, with its padding and no line breaks) stands for. A browser's
// "data:image/jpeg;base64," in front is skipped. Throws MapError(kBadRequest).
std::string DecodeBase64(std::string_view text);

}  // namespace waystone
