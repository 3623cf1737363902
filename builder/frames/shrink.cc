// SPDX-License-Identifier: Apache-2.0
#include "builder/frames/shrink.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/image/encode.h"

namespace waystone {

cv::Mat ShrinkToWidth(const cv::Mat& picture, int width_px) {
  const double factor = std::min(static_cast<double>(width_px) / picture.cols,
                                 static_cast<double>(kMaxPictureSide) / picture.rows);
  if (factor >= 1) return picture;
  const auto scaled = [factor](int side) {
    return std::max(1, static_cast<int>(std::lround(factor * side)));
  };
  cv::Mat small;
  cv::resize(picture, small, {scaled(picture.cols), scaled(picture.rows)}, 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace waystone
