// SPDX-License-Identifier: Apache-2.0
#include "core/features/distance.h"

#include <bit>

namespace waystone {

int32_t DescriptorDistance(FeatureType type, const uint8_t* a, const uint8_t* b) {
  const int bytes = DescriptorBytes(type);
  int32_t sum = 0;
  if (type == FeatureType::kSift) {
    for (int i = 0; i < bytes; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  } else {
    for (int i = 0; i < bytes; ++i) sum += std::popcount(static_cast<uint8_t>(a[i] ^ b[i]));
  }
  return sum;
}

}  // namespace waystone
