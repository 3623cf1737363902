// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/image/formats.h"

// The part of HEVC's syntax (ITU-T H.265) that is read before a picture is decoded: internal to
// core/image. Thread-safe.
namespace waystone {

// Types of network units.
inline constexpr int kHevcFirstIntra = 16;
inline constexpr int kHevcLastIntra = 21;
inline constexpr int kHevcLastSlice = 31;
inline constexpr int kHevcVideoSet = 32;
inline constexpr int kHevcSequenceSet = 33;
inline constexpr int kHevcPictureSet = 34;

struct HevcSize {
  int width = 0;             // px, of what is shown of a picture
  int height = 0;            // px
  int chroma = 0;            // chroma_format_idc
  int bits = 0;              // of a sample, the most of luma and chroma
  int64_t coded_pixels = 0;  // of the whole picture, which is decoded
};

// The type of a unit, or -1 for one without a header and for those of further layers (depth, the
// other eye), which are skipped.
int HevcUnitType(Bytes unit);

// The size in a sequence parameter set. Throws MapError(kBadImage).
HevcSize ReadHevcSize(Bytes unit);

}  // namespace waystone
