// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include "server/http/chunked_body.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

struct TakenChunks {
  std::string body;
  size_t taken = 0;
  bool complete = false;

  bool operator==(const TakenChunks&) const = default;
};

// Hands the bytes over in pieces of a size.
TakenChunks TakeChunks(std::string_view bytes, size_t piece) {
  ChunkedBody chunks;
  TakenChunks result;
  while (result.taken < bytes.size() && !chunks.complete()) {
    result.taken += chunks.Take(bytes.substr(result.taken, piece), result.body);
  }
  result.complete = chunks.complete();
  return result;
}

}  // namespace

// However the bytes arrive they are the same body, no longer than they are; written as one chunk it
// is read again.
bool FuzzChunkedBody(FuzzInput input) {
  const std::string_view bytes = TextOf(input);
  const auto whole = ReadOrRefuse([&] { return TakeChunks(bytes, bytes.size()); });
  for (const size_t piece : {size_t{1}, size_t{7}}) {
    Require(ReadOrRefuse([&] { return TakeChunks(bytes, piece); }) == whole,
            "a body in pieces is the same body");
  }
  if (!whole) return false;
  Require(whole->body.size() <= bytes.size(), "a body is no longer than its chunks");
  if (!whole->complete || whole->body.empty()) return true;
  char size[20];
  std::snprintf(size, sizeof(size), "%zx\r\n", whole->body.size());
  const std::string written = size + whole->body + "\r\n0\r\n\r\n";
  Require(TakeChunks(written, written.size()) == TakenChunks{whole->body, written.size(), true},
          "a body is written as one chunk and read again");
  return true;
}

}  // namespace waystone
