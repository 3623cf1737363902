// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "core/base/random.h"
#include "world/render.h"

namespace waystone::bench {

// The picture, CV_8UC1, under other lamps or another sun: each surface has a brightness of its own,
// up to four shadows with soft edges fall across, and dark pictures are as noisy as bright ones.
cv::Mat Relight(const RenderedFrame& frame, Random& random);

}  // namespace waystone::bench
