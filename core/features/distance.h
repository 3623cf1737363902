// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/features/features.h"

namespace waystone {

// Distance of two descriptors of one type. SIFT: squared Euclidean distance (bytes at most 127, so
// at most 128 * 127^2). ORB, AKAZE: Hamming distance. For many at a time see packed_rows.h.
// Thread-safe.
int32_t DescriptorDistance(FeatureType type, const uint8_t* a, const uint8_t* b);

}  // namespace waystone
