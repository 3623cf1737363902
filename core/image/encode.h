// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace waystone {

// A baseline JPEG of an image (CV_8UC1, or CV_8UC3 as BGR); `quality` from 0 to 100. The image
// isn't empty (WS_CHECK). Throws std::bad_alloc without memory. Thread-safe.
std::vector<uint8_t> EncodeJpeg(const cv::Mat& image, int quality = 95);

}  // namespace waystone
