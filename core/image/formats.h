// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/image/decode.h"

// Header parsers, one a format: inside core/image only. Each is given bytes that start with its
// format's signature, reads them front to back without leaving them, and throws
// MapError(kBadImage).
namespace waystone {

using Bytes = std::span<const uint8_t>;

ImageHeader ReadJpegHeader(Bytes bytes);
// Decodes a JPEG, whose header was read, into an image of its size, grey or BGR, by libjpeg itself:
// through OpenCV nobody hears of data that ends early or isn't what it should be, and libjpeg
// prints it to stderr. False, with nothing decoded, for four colours.
bool DecodeJpeg(Bytes bytes, cv::Mat& image);
ImageHeader ReadPngHeader(Bytes bytes);
// Refuses a PNG, whose header was read, with image data made to take long to inflate: each block of
// deflate brings its own code tables, and many small ones cost a hundred times what their bytes
// cost otherwise. Encoders write blocks of thousands of symbols, or a few a row.
void CheckPngBlocks(Bytes bytes);
// Refuses a PNG with damage in what the decoder needs: it would print the same to stderr.
void CheckPngChecksums(Bytes bytes);
// Whether a PNG has texts, which the decoder would inflate, each to several megabytes; and a copy
// up to its end without them.
bool HasPngTexts(Bytes bytes);
std::vector<uint8_t> WithoutPngTexts(Bytes bytes);
ImageHeader ReadWebpHeader(Bytes bytes);
// The EXIF data of a WebP; empty without.
Bytes WebpExif(Bytes bytes);
// A WebP of the image alone: no alpha beside it, which is coded losslessly, and no colour profile.
std::vector<uint8_t> BareWebp(Bytes bytes);
ImageHeader ReadHeicHeader(Bytes bytes);
ImageHeader ReadBmpHeader(Bytes bytes);
ImageHeader ReadPnmHeader(Bytes bytes);
// Whether a PNM, whose header was read, has another maximum than its samples' bytes can hold, such
// as 4095 for 12 bits, which the decoder would ignore; and a copy with 255 in its place.
bool HasOwnMaximum(Bytes bytes);
std::vector<uint8_t> WithMaximum255(Bytes bytes);

// Throws MapError(kBadImage) with the message.
[[noreturn]] void RefuseImage(const std::string& message);
// The same for an image that ends too early; `missing` says what it lacks.
[[noreturn]] void RefuseCutOff(const std::string& format, Bytes bytes, const std::string& missing);

}  // namespace waystone
