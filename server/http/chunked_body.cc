// SPDX-License-Identifier: Apache-2.0
#include "server/http/chunked_body.h"

#include <algorithm>
#include <charconv>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr size_t kMaxSizeDigits = 15;  // no overflow

[[noreturn]] void FailOnChunk(const std::string& cause) {
  throw MapError(ErrorCode::kBadRequest, "malformed chunked body: " + cause);
}

// The size in "1a;name=value".
int64_t ParseChunkSize(std::string_view line) {
  std::string_view digits = line.substr(0, line.find(';'));
  while (!digits.empty() && (digits.back() == ' ' || digits.back() == '\t'))
    digits.remove_suffix(1);
  int64_t size = 0;
  const char* const end = digits.data() + digits.size();
  const bool sound = !digits.empty() && digits.size() <= kMaxSizeDigits && digits[0] != '-' &&
                     std::from_chars(digits.data(), end, size, 16).ptr == end;
  if (!sound) FailOnChunk("the size of a chunk is not a hexadecimal number");
  return size;
}

}  // namespace

void ChunkedBody::Line(std::string_view line) {
  switch (part_) {
    case Part::kSize:
      left_ = ParseChunkSize(line);
      part_ = left_ > 0 ? Part::kData : Part::kTrailer;
      break;
    case Part::kDataEnd:
      if (!line.empty()) FailOnChunk("a chunk is longer than its size");
      part_ = Part::kSize;
      break;
    case Part::kTrailer:
      if (line.empty()) part_ = Part::kEnd;
      if (++trailers_ > kMaxTrailers) FailOnChunk("too many trailers");
      break;
    case Part::kData:
    case Part::kEnd:
      break;
  }
}

size_t ChunkedBody::Take(std::string_view bytes, std::string& body) {
  size_t at = 0;
  while (at < bytes.size() && part_ != Part::kEnd) {
    if (part_ == Part::kData) {
      const auto taken = std::min(bytes.size() - at, static_cast<size_t>(left_));
      body.append(bytes.substr(at, taken));
      at += taken;
      left_ -= static_cast<int64_t>(taken);
      if (left_ == 0) part_ = Part::kDataEnd;
      continue;
    }
    const char c = bytes[at++];
    if (c != '\n') {
      line_ += c;
      if (line_.size() > kMaxChunkLineBytes) FailOnChunk("a line exceeds 1024 bytes");
      continue;
    }
    if (!line_.ends_with('\r')) FailOnChunk("a line ends without CR LF");
    line_.pop_back();
    Line(line_);
    line_.clear();
  }
  return at;
}

}  // namespace waystone
