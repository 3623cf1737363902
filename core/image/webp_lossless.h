// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/image/formats.h"

// The beginning of a lossless WebP's image (chunk "VP8L"): internal to core/image. Thread-safe.
namespace waystone {

struct LosslessWebp {
  int width = 0;   // px
  int height = 0;  // px
  int groups = 1;  // of prefix codes, at most: a decoder keeps tables for each
};

// Throws MapError(kBadImage). Reads up to and including the map of the groups: linear in the bytes
// and in what precedes the map, at most three images of a sixteenth of the pixels and a palette; no
// allocation.
LosslessWebp ReadLosslessWebp(Bytes data);

}  // namespace waystone
