// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "server/http/request_head.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

// The size of the head, 0 for one that isn't complete, when bytes arrive in pieces of a size.
size_t ScanHead(std::string_view bytes, size_t piece) {
  HeadScanner scanner;
  for (size_t end = std::min(piece, bytes.size());; end = std::min(end + piece, bytes.size())) {
    if (const auto size = scanner.Scan(bytes.substr(0, end))) return *size;
    if (end == bytes.size()) return 0;
  }
}

void CheckRead(const RequestHead& head) {
  Require(head.text.ends_with("\r\n\r\n"), "a head ends with an empty line");
  for (size_t i = 0; i < head.text.size(); ++i) {
    if (head.text[i] == '\r') {
      Require(head.text[i + 1] == '\n', "a head has no CR without LF: others take it for a line");
    }
    if (head.text[i] == '\n') {
      Require(i > 0 && head.text[i - 1] == '\r', "a head has no LF without CR");
    }
  }
  Require(head.body_bytes >= 0, "a body has no negative size");
  if (head.refusal) return;
  Require(!head.has_body() || head.is_post, "only a POST has a body");
  Require(!head.chunked || head.body_bytes == 0, "a body's size is given once");
}

}  // namespace

// However it arrives, a head has the same size or is refused; what is left of it for the HTTP
// library says the same again, and nothing of a body.
bool FuzzHttpHead(FuzzInput input) {
  const std::string_view bytes = TextOf(input);
  const auto size = ReadOrRefuse([&] { return ScanHead(bytes, bytes.size() + 1); });
  for (const size_t piece : {size_t{1}, size_t{13}}) {
    Require(ReadOrRefuse([&] { return ScanHead(bytes, piece); }) == size,
            "a head in pieces has the same size");
  }
  if (size.value_or(0) == 0) return false;
  Require(*size <= kMaxHeadBytes && *size <= bytes.size(), "a head is within its bounds");
  const RequestHead head = ParseRequestHead(bytes.substr(0, *size));
  CheckRead(head);
  const RequestHead again = ParseRequestHead(head.text);
  Require(again.text == head.text && again.is_post == head.is_post &&
              again.is_urgent == head.is_urgent && again.authorization == head.authorization,
          "what is left of a head says the same");
  Require(!again.has_body() && !again.expects_continue, "what is left of a head has no body");
  Require(head.refusal || !again.refusal, "what is left of a sound head is sound");
  return !head.refusal;
}

}  // namespace waystone
