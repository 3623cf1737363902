// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/image/decode.h"

// Header parsers, one per format: internal to core/image. Each is given bytes that start with its
// format's signature, reads them front to back without leaving them, and throws
// MapError(kBadImage). All functions are thread-safe.
namespace waystone {

using Bytes = std::span<const uint8_t>;

ImageHeader ReadJpegHeader(Bytes bytes);
// Decodes a JPEG, whose header was read, into an image of its size, grey or BGR, by libjpeg itself:
// OpenCV doesn't report data that ends early or is invalid, and lets libjpeg print it to stderr.
// False, with nothing decoded, for four colours.
bool DecodeJpeg(Bytes bytes, cv::Mat& image);
ImageHeader ReadPngHeader(Bytes bytes);
// Refuses a PNG, whose header was read, with image data that was crafted to inflate slowly: each
// deflate block has its own code tables, and many small ones cost a hundred times as much per byte.
// Encoders write blocks of thousands of symbols, or a few per row.
void CheckPngBlocks(Bytes bytes);
// Refuses a PNG with damaged chunks that the decoder needs: it would report them to stderr.
void CheckPngChecksums(Bytes bytes);
// Whether a PNG has text chunks, each of which the decoder would inflate to several megabytes; and
// a copy of the PNG without them.
bool HasPngTexts(Bytes bytes);
std::vector<uint8_t> WithoutPngTexts(Bytes bytes);
ImageHeader ReadWebpHeader(Bytes bytes);
// The EXIF data of a WebP; empty where it has none.
Bytes WebpExif(Bytes bytes);
// The WebP with its image only, without alpha (which is coded losslessly) and colour profile.
std::vector<uint8_t> BareWebp(Bytes bytes);
ImageHeader ReadHeicHeader(Bytes bytes);
ImageHeader ReadBmpHeader(Bytes bytes);
ImageHeader ReadPnmHeader(Bytes bytes);
// Whether a PNM, whose header was read, has a maximum other than the largest that its samples'
// bytes can hold, such as 4095 for 12 bits, which the decoder would ignore; and a copy with 255 in
// its place.
bool HasOwnMaximum(Bytes bytes);
std::vector<uint8_t> WithMaximum255(Bytes bytes);

// Throws MapError(kBadImage) with the message.
[[noreturn]] void RefuseImage(const std::string& message);
// The same for an image that ends too early; `missing` says what it lacks.
[[noreturn]] void RefuseCutOff(const std::string& format, Bytes bytes, const std::string& missing);

}  // namespace waystone
