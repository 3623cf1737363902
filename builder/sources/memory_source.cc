// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/memory_source.h"

namespace waystone {

std::string MemorySource::Announcement() const {
  return "Sequence in memory, " + std::to_string(size()) + (size() == 1 ? " frame" : " frames");
}

std::optional<EncodedFrame> MemorySource::NextEncoded() {
  if (next_ == size()) return std::nullopt;
  return sequence_.frames[next_++];
}

}  // namespace waystone
