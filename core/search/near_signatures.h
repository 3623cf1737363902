// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace waystone {

struct NearSignature {
  uint32_t index = 0;    // in the list that was searched
  int32_t distance = 0;  // bits (SignatureDistance)

  bool operator==(const NearSignature&) const = default;
};

// Appends those signatures of a list that differ from `wanted` in at most `max_distance` bits, in
// their order. Thread-safe; the same on every machine.
void AppendNear(std::span<const uint64_t> signatures, uint64_t wanted, int max_distance,
                std::vector<NearSignature>& near);

}  // namespace waystone
