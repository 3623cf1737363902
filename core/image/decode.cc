// SPDX-License-Identifier: Apache-2.0
#include "core/image/decode.h"

#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"

namespace waystone {
namespace {

[[noreturn]] void RefuseSize(const std::string& message) {
  throw MapError(ErrorCode::kImageTooLarge, message);
}

// Nothing but MapError leaves this, whatever OpenCV thinks of the bytes.
cv::Mat Decode(std::span<const uint8_t> bytes, const DecodeLimits& limits, int flags) {
  limits.Check();
  if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
    RefuseSize("the image has " + std::to_string(bytes.size()) + " bytes; the limit is 2147483647");
  }
  const ImageHeader header = ReadImageHeader(bytes);
  CheckLimits(header, limits);
  cv::Mat image;
  std::string cause = "its pixels can't be decoded";
  try {
    // imdecode takes a Mat that it doesn't change.
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<uint8_t*>(bytes.data()));
    image = cv::imdecode(encoded, flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    cause = error.err;
  }
  if (image.cols != header.width || image.rows != header.height) {
    throw MapError(ErrorCode::kBadImage,
                   "the " + header.format + " of " + std::to_string(bytes.size()) +
                       " bytes is damaged: " + cause + "; copy or send the file again");
  }
  return image;
}

}  // namespace

void DecodeLimits::Check() const {
  constexpr int64_t kMaxPixels = int64_t{1} << 30;  // what OpenCV itself refuses
  constexpr int kMaxScans = 10'000;
  if (max_pixels < 1 || max_pixels > kMaxPixels) {
    throw MapError(ErrorCode::kBadOptions, "max_pixels is " + std::to_string(max_pixels) +
                                               "; it must be between 1 and " +
                                               std::to_string(kMaxPixels));
  }
  if (max_scans < 1 || max_scans > kMaxScans) {
    throw MapError(ErrorCode::kBadOptions, "max_scans is " + std::to_string(max_scans) +
                                               "; it must be between 1 and " +
                                               std::to_string(kMaxScans));
  }
}

void CheckLimits(const ImageHeader& header, const DecodeLimits& limits) {
  const int64_t pixels = static_cast<int64_t>(header.width) * header.height;
  if (pixels > limits.max_pixels) {
    RefuseSize("the image has " + std::to_string(header.width) + "x" +
               std::to_string(header.height) + " = " + std::to_string(pixels) +
               " pixels, more than the limit of " + std::to_string(limits.max_pixels) +
               "; downscale it");
  }
  if (header.scans > limits.max_scans) {
    RefuseSize("the JPEG has " + std::to_string(header.scans) + " scans, more than the limit of " +
               std::to_string(limits.max_scans) + "; save it again as a baseline JPEG");
  }
}

cv::Mat DecodeGrey(std::span<const uint8_t> bytes, const DecodeLimits& limits) {
  return Decode(bytes, limits, cv::IMREAD_GRAYSCALE);
}

cv::Mat DecodeColour(std::span<const uint8_t> bytes, const DecodeLimits& limits) {
  return Decode(bytes, limits, cv::IMREAD_COLOR);
}

}  // namespace waystone
