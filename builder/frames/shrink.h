// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace waystone {

// The picture at most `width_px` wide and kMaxPictureSide high, averaged over areas; itself where
// it is no larger than that. Thread-safe.
cv::Mat ShrinkToWidth(const cv::Mat& picture, int width_px);

}  // namespace waystone
