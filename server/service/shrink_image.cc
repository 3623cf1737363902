// SPDX-License-Identifier: Apache-2.0
#include "server/service/shrink_image.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/base/error.h"
#include "core/image/decode.h"
#include "core/image/encode.h"

namespace waystone {
namespace {

constexpr int kJpegQuality = 80;  // of copies for people

// Maps are strangers' files. Builds store pictures of at most 4096 px in width; upright photos
// (3:4) then have 22 megapixels. They are WebP, and used to be baseline JPEG: one in several scans
// isn't ours, but may be as large as the usual 12 megapixels.
DecodeLimits StoredLimits() {
  DecodeLimits limits;
  limits.max_pixels = 24'000'000;
  limits.max_scan_pixels = 240'000'000;
  limits.max_decode_bytes = 100'000'000;
  return limits;
}

cv::Mat DecodeStored(const std::vector<uint8_t>& picture) {
  try {
    return DecodeColour(picture, StoredLimits());
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kImageTooLarge) throw;
  }
  const ImageHeader header = ReadImageHeader(picture);
  throw MapError(ErrorCode::kNotAvailable,
                 "the map's picture of " + std::to_string(header.width) + "x" +
                     std::to_string(header.height) + " px and " + std::to_string(picture.size()) +
                     " bytes takes too much memory to resize; request it without width");
}

}  // namespace

bool IsWider(const std::vector<uint8_t>& picture, int width) {
  return ReadImageHeader(picture).width > width;
}

std::vector<uint8_t> ShrunkPicture(const std::vector<uint8_t>& picture, int width) {
  const cv::Mat image = DecodeStored(picture);
  const int height = std::max(1, image.rows * width / image.cols);
  cv::Mat small;
  cv::resize(image, small, {width, height}, 0, 0, cv::INTER_AREA);
  return EncodeJpeg(small, kJpegQuality);
}

}  // namespace waystone
