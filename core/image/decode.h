// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "core/base/options.h"

namespace waystone {

// What an encoded image's header says, read without decoding a pixel.
struct ImageHeader {
  std::string format;  // "jpeg", "png", "webp", "heic", "bmp", "pnm"
  int width = 0;       // px
  int height = 0;      // px
  int scans = 1;       // JPEG: how many scans (a progressive one has several)
  // What decoding takes at once: for a JPEG in several scans, what the decoder keeps until the last
  // one. HEIC: its pictures and the image. Lossless WebP: the image, and tables. 0 for the others,
  // which are decoded row by row.
  int64_t decode_bytes = 0;
  int64_t inflated_bytes = 0;  // PNG: what its image data inflate to
  int64_t hevc_bytes = 0;      // HEIC: of its coded pictures
};

struct DecodeLimits {
  int64_t max_pixels = 50'000'000;
  int max_scans = 100;
  int64_t max_scan_pixels = 1'000'000'000;
  int64_t max_decode_bytes = 250'000'000;
  int64_t max_inflated_bytes = 160'000'000;
  int64_t max_hevc_bytes = 8'000'000;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_pixels", &DecodeLimits::max_pixels, Closed(1, 1 << 30), "",
                    "Maximum number of pixels of an image that is decoded; 8-bit grey takes as "
                    "many bytes. Higher values admit larger photos, but also larger attacks: "
                    "decoding 50 megapixels takes half a second."},
        OptionField{"max_scans", &DecodeLimits::max_scans, Closed(1, 10'000), "",
                    "Maximum number of scans of a progressive JPEG: each costs a pass over the "
                    "whole image. Encoders write about 10."},
        OptionField{"max_scan_pixels", &DecodeLimits::max_scan_pixels, AtLeast(1), "",
                    "Maximum product of scans and pixels of a progressive JPEG, to which decoding "
                    "time is proportional: about a second for a billion."},
        OptionField{"max_decode_bytes", &DecodeLimits::max_decode_bytes, AtLeast(1), "bytes",
                    "Maximum memory for decoding an image. For a progressive JPEG: two bytes per "
                    "coefficient, so 192 MB for 48 megapixels with halved chroma, plus the image. "
                    "For a HEIC: three times its largest tile, plus the image. For a lossless "
                    "WebP: 9 bytes per pixel, plus 13 KB per group of codes."},
        OptionField{"max_inflated_bytes", &DecodeLimits::max_inflated_bytes, AtLeast(1), "bytes",
                    "Maximum size of a PNG's uncompressed pixels, to which decoding time is "
                    "proportional: about 10 ns per pixel. 50 megapixels of 24 bits take 150 MB."},
        OptionField{"max_hevc_bytes", &DecodeLimits::max_hevc_bytes, AtLeast(1), "bytes",
                    "Maximum size of a HEIC's coded images, with which decoding time grows: 0.3 s "
                    "for 12 megapixels in 0.5 MB, 0.2 s for 2 megapixels in 1.1 MB."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Parses the header, and walks over the rest as far as needed to know that its end is there; bytes
// after the end are allowed. Linear in the bytes; allocates only for a HEIC's tables. Throws
// MapError(kBadImage) for bytes that are not a JPEG, PNG, WebP, HEIC, BMP or PNM or are cut off (a
// JPEG without its end marker, a PNG without IEND), naming what they look like; for
// arithmetic-coded JPEGs, which take ten times as long; for a PNG with more image data than its
// pixels can need; and for animated WebPs. The end of a HEIC may be followed only by further boxes;
// its tables take a few times their bytes in memory. Never reads outside `bytes`. Thread-safe.
ImageHeader ReadImageHeader(std::span<const uint8_t> bytes);

// Throws MapError(kImageTooLarge), with the claimed value and the limit, for a header over the
// limits. Thread-safe.
void CheckLimits(const ImageHeader& header, const DecodeLimits& limits);

// Decodes an image of one pixel. OpenCV sets up all its decoders with the first image of a process,
// and a library used by one of them (GDAL) ends the process when memory runs out meanwhile:
// processes that must survive that call this first. Thread-safe.
void PrepareDecoders();

// Decodes to 8-bit grey (CV_8UC1), and refuses by its header an image over the limits
// (kImageTooLarge): with the default limits nothing takes more than 300 MB, and a HEIC of 49
// megapixels and 5.8 MB, the slowest image measured, takes 2 s. EXIF orientation is not applied,
// nor are a HEIC's rotation, mirroring and cropping: pixels are where the camera put them, which is
// what calibrations and answers refer to. 16-bit images become 8-bit ones, by their upper bytes; a
// PNM's maximum becomes 255. Throws MapError(kBadImage) when it can't be decoded, including a JPEG
// whose data ends early or has invalid codes above its last row of blocks, and std::bad_alloc.
// Thread-safe.
cv::Mat DecodeGrey(std::span<const uint8_t> bytes, const DecodeLimits& limits = {});

// The same in colour (CV_8UC3, BGR).
cv::Mat DecodeColour(std::span<const uint8_t> bytes, const DecodeLimits& limits = {});

}  // namespace waystone
