// SPDX-License-Identifier: Apache-2.0
#include "builder/frames/shrink.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace waystone {

cv::Mat ShrinkToWidth(const cv::Mat& picture, int width_px) {
  if (picture.cols <= width_px) return picture;
  const double height = static_cast<double>(picture.rows) * width_px / picture.cols;
  cv::Mat small;
  cv::resize(picture, small, {width_px, std::max(1, static_cast<int>(std::lround(height)))}, 0, 0,
             cv::INTER_AREA);
  return small;
}

}  // namespace waystone
