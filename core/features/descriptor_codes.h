// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/features/features.h"

// Descriptors compressed to a quarter of their bytes, for storing many features.
namespace waystone {

// Bytes of one descriptor's code: 32 for SIFT; ORB and AKAZE are bits already and stay as they are.
int CodeBytes(FeatureType type);

// SIFT: each entry becomes the nearest of four levels, 2 bits, the first entry in the lowest bits
// of the first byte. A decoded descriptor matches full ones nearly as the original does, since
// rounding errors are small beside the differences between descriptors. Row i of the codes belongs
// to row i of the descriptors. Pure; thread-safe, as all here.
Descriptors EncodeDescriptors(DescriptorsView descriptors, FeatureType type);

// The descriptors that codes stand for, of ExtractFeatures' length (256 for SIFT).
Descriptors DecodeDescriptors(DescriptorsView codes, FeatureType type);

}  // namespace waystone
