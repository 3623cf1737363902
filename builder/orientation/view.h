// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "builder/frames/layer_builder.h"
#include "builder/orientation/options.h"
#include "core/camera/rig.h"

namespace waystone {

// What is extracted from the images of one moment: the part of the work that needs no other frame.
// Empty where they could not be read.
struct OrientationView : Observation {
  std::vector<GreatCircle> lines;
  ManhattanFrame frame;  // axes numbered arbitrarily until they are followed
  BearingFeatures features;
  cv::Mat thumbnail;  // of the first camera; empty when none is wanted
};

using OrientationViewPtr = std::shared_ptr<const OrientationView>;

// Finds lines, their directions and features in a rig's images, one per camera (CV_8UC1). Throws
// MapError(kBadImage) for one that doesn't have its camera's size. Deterministic; thread-safe.
std::unique_ptr<OrientationView> ObserveOrientation(const Rig& rig, const FrameInfo& info,
                                                    std::span<const cv::Mat> images,
                                                    const OrientationOptions& options);

}  // namespace waystone
