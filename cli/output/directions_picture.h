// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/camera/rig.h"
#include "core/manhattan/great_circles.h"
#include "core/manhattan/manhattan_frame.h"

namespace waystone {

// The images of a moment (CV_8UC1, one per camera of the rig) side by side in colour (BGR), with
// their lines in the colours of their axes: 1 red, 2 green, 3 blue, none grey. The arrows in a
// corner are the axes as that camera sees them; a ring is a vanishing point in the image. Small
// images are enlarged. `frame` is that of `lines`. Pure; thread-safe.
cv::Mat DrawDirections(const Rig& rig, std::span<const cv::Mat> images,
                       std::span<const GreatCircle> lines, const ManhattanFrame& frame);

}  // namespace waystone
