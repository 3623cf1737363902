// SPDX-License-Identifier: Apache-2.0
#include "core/image/encode.h"

#include <opencv2/imgcodecs.hpp>

#include "core/base/check.h"
#include "core/base/memory_reservation.h"

namespace waystone {
namespace {

// OpenCV's encoder crashes when libjpeg can't have its first allocations.
int64_t EncodingBytes(const cv::Mat& image) {
  constexpr int64_t kWorkspace = 4 << 20;
  return kWorkspace + 4 * static_cast<int64_t>(image.total());
}

}  // namespace

std::vector<uint8_t> EncodeJpeg(const cv::Mat& image, int quality) {
  const MemoryReservation room(EncodingBytes(image));
  std::vector<uint8_t> jpeg;
  WS_CHECK(cv::imencode(".jpg", image, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality}),
           "OpenCV can't encode a JPEG");
  return jpeg;
}

}  // namespace waystone
