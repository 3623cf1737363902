// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/features/features.h"

namespace waystone {

// Distances of one descriptor to `rows` descriptors that lie one after the other in memory.
// SIFT: squared Euclidean distance (bytes at most 127, so at most 128 * 127^2). ORB, AKAZE:
// Hamming distance. out[i] belongs to row i. Thread-safe.
using DistanceKernel = void (*)(const uint8_t* query, const uint8_t* block, int rows, int bytes,
                                int32_t* out);

// The fastest kernel for `type` on this processor, chosen at run time. All give the same numbers.
DistanceKernel FastestKernel(FeatureType type);

// Every kernel for `type` that this processor can run, the portable one first: for tests, benches.
struct NamedKernel {
  const char* name;
  DistanceKernel kernel;
};
std::vector<NamedKernel> RunnableKernels(FeatureType type);

}  // namespace waystone
