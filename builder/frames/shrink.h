// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace waystone {

// The picture `width_px` wide, averaged over areas; itself where it isn't wider than that.
cv::Mat ShrinkToWidth(const cv::Mat& picture, int width_px);

}  // namespace waystone
