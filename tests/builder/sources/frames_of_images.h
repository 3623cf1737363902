// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "builder/sources/source.h"
#include "core/base/error.h"

namespace waystone {

// Frames "0", "1", ... of these images (CV_8UC1), for a MemorySource; an empty one can't be
// decoded.
inline std::vector<EncodedFrame> FramesOfImages(const std::vector<cv::Mat>& images) {
  std::vector<EncodedFrame> frames;
  for (const cv::Mat& image : images) {
    const auto number = static_cast<int>(frames.size());
    frames.emplace_back(FrameInfo{number, std::to_string(number), {}}, [image] {
      if (image.empty()) throw MapError(ErrorCode::kBadImage, "no image");
      return image;
    });
  }
  return frames;
}

}  // namespace waystone
