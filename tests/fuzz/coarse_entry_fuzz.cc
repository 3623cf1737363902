// SPDX-License-Identifier: Apache-2.0
#include "localizer/coarse/coarse_entry.h"

#include "tests/fuzz/fuzz_targets.h"

namespace waystone {

// What is read is within its bounds, and is written to the same bytes.
bool FuzzCoarseEntry(FuzzInput input) {
  const std::string_view bytes = TextOf(input);
  const auto entry = ReadOrRefuse([&] { return DecodeCoarseEntry(bytes, "it"); });
  if (!entry) return false;
  Require(entry->keyframes <= entry->places(), "keyframes are places");
  Require(entry->words.size() == entry->signatures.size(), "codes are whole");
  size_t codes = 0;
  for (const uint8_t count : entry->codes_of) {
    Require(count <= kMaxPlaceCodes, "a place has a bounded number of codes");
    codes += count;
  }
  Require(codes == entry->words.size(), "every code belongs to a place");
  Require(EncodeCoarseEntry(*entry) == bytes, "what is read is written to the same bytes");
  return true;
}

}  // namespace waystone
