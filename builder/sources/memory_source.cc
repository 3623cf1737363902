// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/memory_source.h"

#include "core/base/error.h"

namespace waystone {

std::string MemorySource::Announcement() const {
  return "Sequence in memory, " + std::to_string(size()) + (size() == 1 ? " frame" : " frames");
}

std::optional<EncodedFrame> MemorySource::NextEncoded() {
  if (next_ == size()) return std::nullopt;
  return sequence_.frames[next_++];
}

std::vector<EncodedFrame> FramesOfImages(const std::vector<cv::Mat>& images) {
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
