// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "core/base/random.h"

namespace waystone {

// Changes bytes somehow; the result has at most `max_bytes`.
using MutateBytes = std::function<std::string(std::string bytes, size_t max_bytes)>;

// One to four simple changes, the same for the same numbers drawn: bits, bytes, whole numbers at
// their limits, and stretches that are removed, repeated, or taken from `other`.
std::string MutateSimply(std::string bytes, const std::string& other, size_t max_bytes,
                         Random& random);

// A mutation by `mutate`, followed by one that some readers need to get behind their checks:
// recomputes the checksums of a PNG's chunks, three times of four.
std::string MutateImage(std::string bytes, size_t max_bytes, uint32_t seed,
                        const MutateBytes& mutate);

// A map file, compressed by zlib: changes a cell, removes a row or changes the file's bytes, and
// then mostly makes every checksum of the map right again.
std::string MutateMap(std::string bytes, size_t max_bytes, uint32_t seed,
                      const MutateBytes& mutate);

}  // namespace waystone
