// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

// Bodies of several parts, and bytes encoded as text. All functions are pure; thread-safe.
namespace waystone {

// The media type in lower case, without parameters: "multipart/form-data" of "Multipart/Form-Data;
// boundary=x".
std::string MediaTypeOf(const std::string& content_type);

struct BodyPart {
  std::string name;
  std::string filename;    // empty without one
  std::string_view bytes;  // part of the body, which must outlive it
};

// The parts of a multipart/form-data body (RFC 7578), in order. `content_type` is the header, with
// the boundary. Text before the first boundary, blanks after one and folded headers of parts are
// accepted (RFC 2046, section 5.1.1). Linear in the body's size, and copies none of it. Throws
// MapError(kBadRequest) for any other body and for more than `max_parts` parts.
std::vector<BodyPart> ParseMultipart(std::string_view body, const std::string& content_type,
                                     size_t max_parts);

// The bytes encoded by base64 (RFC 4648, padded, without line breaks). A browser's
// "data:image/jpeg;base64," in front is skipped. Throws MapError(kBadRequest) for any other text.
std::string DecodeBase64(std::string_view text);

}  // namespace waystone
