// SPDX-License-Identifier: Apache-2.0
#include "core/search/near_signatures.h"

#include "core/search/words.h"

namespace waystone {
namespace {

using Search = void (*)(std::span<const uint64_t>, uint64_t, int, std::vector<NearSignature>&);

// Inlined into a function per instruction set, so that popcount becomes one instruction there.
inline __attribute__((always_inline)) void AppendEachNear(std::span<const uint64_t> signatures,
                                                          uint64_t wanted, int max_distance,
                                                          std::vector<NearSignature>& near) {
  for (uint32_t i = 0; i < signatures.size(); ++i) {
    const int distance = SignatureDistance(signatures[i], wanted);
    if (distance <= max_distance) near.push_back({i, distance});
  }
}

void Portable(std::span<const uint64_t> signatures, uint64_t wanted, int max_distance,
              std::vector<NearSignature>& near) {
  AppendEachNear(signatures, wanted, max_distance, near);
}

#if defined(__x86_64__)

__attribute__((target("popcnt"))) void Popcnt(std::span<const uint64_t> signatures, uint64_t wanted,
                                              int max_distance, std::vector<NearSignature>& near) {
  AppendEachNear(signatures, wanted, max_distance, near);
}

#endif

Search Fastest() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("popcnt")) return Popcnt;
#endif
  return Portable;
}

}  // namespace

void AppendNear(std::span<const uint64_t> signatures, uint64_t wanted, int max_distance,
                std::vector<NearSignature>& near) {
  static const Search search = Fastest();
  search(signatures, wanted, max_distance, near);
}

}  // namespace waystone
