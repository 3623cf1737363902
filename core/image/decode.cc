// SPDX-License-Identifier: Apache-2.0
#include "core/image/decode.h"

#include <cerrno>
#include <limits>
#include <new>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/image/formats.h"
#include "core/image/heic.h"

namespace waystone {
namespace {

[[noreturn]] void RefuseSize(const std::string& message) {
  throw MapError(ErrorCode::kImageTooLarge, message);
}

// Throws only MapError and std::bad_alloc, whatever OpenCV makes of the bytes.
cv::Mat Decode(std::span<const uint8_t> bytes, const DecodeLimits& limits, int flags) {
  limits.Check();
  if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
    RefuseSize("the image has " + std::to_string(bytes.size()) + " bytes; the limit is 2147483647");
  }
  const ImageHeader header = ReadImageHeader(bytes);
  CheckLimits(header, limits);
  if (header.format == "heic") return DecodeHeic(ReadHeic(bytes), flags == cv::IMREAD_COLOR);
  std::vector<uint8_t> reduced;
  if (header.format == "png") {
    CheckPngChecksums(bytes);
    CheckPngBlocks(bytes);
    if (HasPngTexts(bytes)) bytes = reduced = WithoutPngTexts(bytes);
  } else if (header.format == "webp") {
    bytes = reduced = BareWebp(bytes);
  } else if (header.format == "pnm" && HasOwnMaximum(bytes)) {
    bytes = reduced = WithMaximum255(bytes);
  }
  cv::Mat image;
  std::string cause = "its pixels can't be decoded";
  errno = 0;
  try {
    if (header.format == "jpeg") {
      image.create(header.height, header.width, flags == cv::IMREAD_COLOR ? CV_8UC3 : CV_8UC1);
      if (DecodeJpeg(bytes, image)) return image;
    }
    // imdecode takes a Mat that it doesn't change.
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<uint8_t*>(bytes.data()));
    image = cv::imdecode(encoded, flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    cause = error.err;
  }
  if (image.cols != header.width || image.rows != header.height) {
    // The decoders don't report what went wrong, but a failed malloc sets errno.
    if (errno == ENOMEM) throw std::bad_alloc();
    throw MapError(ErrorCode::kBadImage,
                   "the " + header.format + " of " + std::to_string(bytes.size()) +
                       " bytes is damaged: " + cause + "; copy or send the file again");
  }
  return image;
}

}  // namespace

void DecodeLimits::Check() const { CheckFields("decode", *this); }

void CheckLimits(const ImageHeader& header, const DecodeLimits& limits) {
  const int64_t pixels = static_cast<int64_t>(header.width) * header.height;
  if (pixels > limits.max_pixels) {
    RefuseSize("the image has " + std::to_string(header.width) + "x" +
               std::to_string(header.height) + " = " + std::to_string(pixels) +
               " pixels, more than the limit of " + std::to_string(limits.max_pixels) +
               "; downscale it");
  }
  if (header.decode_bytes > limits.max_decode_bytes) {
    const std::string name = header.format == "heic"   ? "HEIC"
                             : header.format == "webp" ? "lossless WebP"
                                                       : "progressive JPEG";
    RefuseSize("the " + name + " takes " + std::to_string(header.decode_bytes / 1'000'000) +
               " MB to decode, more than the limit of " +
               std::to_string(limits.max_decode_bytes / 1'000'000) +
               "; save it again as a baseline JPEG");
  }
  if (header.hevc_bytes > limits.max_hevc_bytes) {
    RefuseSize("the HEIC has " + std::to_string(header.hevc_bytes) +
               " bytes of pictures, more than the limit of " +
               std::to_string(limits.max_hevc_bytes) + "; save it as JPEG");
  }
  if (header.inflated_bytes > limits.max_inflated_bytes) {
    RefuseSize("the PNG has " + std::to_string(header.inflated_bytes / 1'000'000) +
               " MB of pixels, more than the limit of " +
               std::to_string(limits.max_inflated_bytes / 1'000'000) +
               "; save it with 8 bits a colour and without alpha");
  }
  if (header.scans > 1 && header.scans * pixels > limits.max_scan_pixels) {
    RefuseSize("the JPEG has " + std::to_string(header.scans) + " scans of " +
               std::to_string(pixels) + " pixels, together more than the limit of " +
               std::to_string(limits.max_scan_pixels) + "; save it again as a baseline JPEG");
  }
  if (header.scans > limits.max_scans) {
    RefuseSize("the JPEG has " + std::to_string(header.scans) + " scans, more than the limit of " +
               std::to_string(limits.max_scans) + "; save it again as a baseline JPEG");
  }
}

void PrepareDecoders() {
  constexpr std::string_view kPixel = "P5 1 1 255 x";
  const std::vector<uint8_t> bytes(kPixel.begin(), kPixel.end());
  DecodeGrey(bytes);
}

cv::Mat DecodeGrey(std::span<const uint8_t> bytes, const DecodeLimits& limits) {
  return Decode(bytes, limits, cv::IMREAD_GRAYSCALE);
}

cv::Mat DecodeColour(std::span<const uint8_t> bytes, const DecodeLimits& limits) {
  return Decode(bytes, limits, cv::IMREAD_COLOR);
}

}  // namespace waystone
