// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "core/features/features.h"

namespace waystone {

inline constexpr FeatureType kAllTypes[] = {FeatureType::kSift, FeatureType::kOrb,
                                            FeatureType::kAkaze};

// Random descriptors whose bytes are in the type's range. `levels` below 128 makes ties frequent.
inline Descriptors MadeDescriptors(FeatureType type, int rows, Random& random, int levels = 256) {
  const int bytes = DescriptorBytes(type);
  const int largest = type == FeatureType::kSift ? 128 : 256;
  std::vector<uint8_t> data(static_cast<size_t>(rows) * bytes);
  for (uint8_t& byte : data) byte = random.Below(std::min(levels, largest));
  return {bytes, std::move(data)};
}

// The distance as features.h and distance.h define it, byte by byte and bit by bit.
inline int NaiveDistance(FeatureType type, const uint8_t* a, const uint8_t* b) {
  int sum = 0;
  for (int i = 0; i < DescriptorBytes(type); ++i) {
    if (type == FeatureType::kSift) {
      sum += (a[i] - b[i]) * (a[i] - b[i]);
    } else {
      for (int bit = 0; bit < 8; ++bit) sum += ((a[i] >> bit) & 1) != ((b[i] >> bit) & 1);
    }
  }
  return sum;
}

}  // namespace waystone
