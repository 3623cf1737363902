// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace waystone {

// Of a chunk's size with its extensions, and of a trailer.
constexpr size_t kMaxChunkLineBytes = 1024;
constexpr int kMaxTrailers = 20;

// Takes the chunks of a body (RFC 9112, section 7.1) apart. Extensions and trailers are read over.
// Inside server/http only.
class ChunkedBody {
 public:
  // Appends to `body` what `bytes` hold of it, and returns how many of them were taken: all, but
  // for what follows the end. Throws MapError(kBadRequest) for what is no chunk.
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
