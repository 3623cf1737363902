// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/image/formats.h"

// HEIC (ISO/IEC 23008-12 with HEVC): internal to core/image. Accepts what cameras write: a primary
// image that is one intra picture (hvc1) or a grid of them, each in one piece. The file's rotation,
// mirroring and cropping are not applied, as EXIF's orientation isn't. Anything that another reader
// could interpret differently (a box or an item twice) is refused.
namespace waystone {

// One intra picture as HEVC's network units, without their lengths.
struct HevcPicture {
  std::vector<Bytes> units;  // parameter sets, then slices: inside the file's bytes
};

struct HeicImage {
  int width = 0;   // px
  int height = 0;  // px
  int columns = 1;
  std::vector<HevcPicture> tiles;  // row by row
  int tile_width = 0;              // px, each of them
  int tile_height = 0;             // px
  int64_t coded_pixels = 0;        // of each, including the part that isn't shown
  int chroma = 0;                  // HEVC's chroma_format_idc: 0 grey, 1 4:2:0, 2 4:2:2, 3 4:4:4
  int bits = 0;                    // of a sample, 8 to 16
  std::optional<bool> full_range;  // what the file says beside the pictures

  // What decoding takes: the decoder's pictures, and the planes that they are put into.
  int64_t DecodeBytes() const;
  int64_t HevcBytes() const;  // of all tiles' units, which its time grows with
};

// `bytes` start with a box "ftyp". Throws MapError(kBadImage). Bounded by the bytes in time and
// memory.
HeicImage ReadHeic(Bytes bytes);
// The TIFF of its EXIF data; empty where it has none. Throws as ReadHeic does.
Bytes HeicExif(Bytes bytes);

// CV_8UC1, or CV_8UC3 (BGR, by BT.601, for people to look at). Throws MapError(kBadImage), and
// std::bad_alloc. Thread-safe.
cv::Mat DecodeHeic(const HeicImage& image, bool colour);

}  // namespace waystone
