// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace waystone {

// A baseline JPEG of an image (CV_8UC1, or CV_8UC3 as BGR); `quality` from 0 to 100. The image
// isn't empty (WS_CHECK). Throws std::bad_alloc when memory runs out. Thread-safe.
std::vector<uint8_t> EncodeJpeg(const cv::Mat& image, int quality = 95);

inline constexpr int kMaxPictureSide = 16'383;  // px, of a WebP

// A picture as maps keep it: a lossy WebP of `quality` from 1 to 100, which takes 0.4 to 0.7 times
// the bytes of a JPEG of the same visual quality. No side exceeds kMaxPictureSide (WS_CHECK).
// Otherwise as EncodeJpeg.
std::vector<uint8_t> EncodePicture(const cv::Mat& image, int quality);

// "image/jpeg", "image/png" or "image/webp" for a picture that a map keeps, by its first byte.
// Thread-safe.
const char* MediaTypeOf(std::span<const uint8_t> picture);

}  // namespace waystone
