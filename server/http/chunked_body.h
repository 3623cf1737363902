// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace waystone {

// Bounds on the line of a chunk's size with its extensions, and on the trailers.
constexpr size_t kMaxChunkLineBytes = 1024;
constexpr int kMaxTrailers = 20;

// Decodes a chunked body (RFC 9112, section 7.1). Extensions and trailers are ignored. Internal to
// server/http. Not thread-safe.
class ChunkedBody {
 public:
  // Appends what `bytes` hold of the body to `body`, and returns how many of them were taken: all
  // but those after the body's end. Throws MapError(kBadRequest) for malformed chunks.
  size_t Take(std::string_view bytes, std::string& body);

  bool complete() const { return part_ == Part::kEnd; }

 private:
  enum class Part { kSize, kData, kDataEnd, kTrailer, kEnd };

  void Line(std::string_view line);

  Part part_ = Part::kSize;
  std::string line_;
  int64_t left_ = 0;  // of the chunk's data
  int trailers_ = 0;
};

}  // namespace waystone
