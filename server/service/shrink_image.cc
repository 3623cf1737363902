// SPDX-License-Identifier: Apache-2.0
#include "server/service/shrink_image.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/image/decode.h"
#include "core/image/encode.h"

namespace waystone {
namespace {

constexpr int kJpegQuality = 80;  // of copies for people

}  // namespace

std::vector<uint8_t> ShrunkPicture(const std::vector<uint8_t>& picture, int width) {
  const ImageHeader header = ReadImageHeader(picture);
  if (header.width <= width) return picture;
  const cv::Mat image = DecodeColour(picture);
  const int height = std::max(1, image.rows * width / image.cols);
  cv::Mat small;
  cv::resize(image, small, {width, height}, 0, 0, cv::INTER_AREA);
  return EncodeJpeg(small, kJpegQuality);
}

}  // namespace waystone
