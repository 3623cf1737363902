// SPDX-License-Identifier: Apache-2.0
#include "core/image/encode.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "core/base/check.h"
#include "core/base/memory_reservation.h"

namespace waystone {
namespace {

// OpenCV's encoder crashes when libjpeg can't have its first allocations, and libwebp says only
// that it failed.
std::vector<uint8_t> Encode(const cv::Mat& image, const char* extension, int64_t bytes_per_pixel,
                            const std::vector<int>& flags) {
  constexpr int64_t kWorkspace = 4 << 20;
  const MemoryReservation room(kWorkspace + bytes_per_pixel * static_cast<int64_t>(image.total()));
  std::vector<uint8_t> encoded;
  WS_CHECK(cv::imencode(extension, image, encoded, flags), "OpenCV can't encode the image");
  return encoded;
}

}  // namespace

std::vector<uint8_t> EncodeJpeg(const cv::Mat& image, int quality) {
  return Encode(image, ".jpg", 4, {cv::IMWRITE_JPEG_QUALITY, quality});
}

std::vector<uint8_t> EncodePicture(const cv::Mat& image, int quality) {
  WS_CHECK(std::max(image.cols, image.rows) <= kMaxPictureSide, "a picture too long for a WebP");
  return Encode(image, ".webp", 16, {cv::IMWRITE_WEBP_QUALITY, quality});
}

const char* MediaTypeOf(std::span<const uint8_t> picture) {
  if (picture.empty()) return "application/octet-stream";
  return picture[0] == 0xFF ? "image/jpeg" : picture[0] == 'R' ? "image/webp" : "image/png";
}

}  // namespace waystone
