// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace waystone {

// words.bin, which CMake puts into the program: of SIFT, ORB and AKAZE, in this order, 256
// prototypes each (core/search/words.h). Internal to core/search.
extern const std::span<const uint8_t> kWordsData;

}  // namespace waystone
