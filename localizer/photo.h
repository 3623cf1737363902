// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/camera/camera.h"
#include "localizer/answer.h"
#include "localizer/map_index.h"
#include "localizer/options.h"

namespace waystone {

// Where was this perspective photo taken, asked of a map of panoramas? Its features become rays by
// the camera and are matched with what each node saw in the columns that the photo sees; the nodes
// with the most matches are verified by relative poses, as panoramas are, of which two must agree
// in the photo's heading (its optical axis's). Nodes without features can't be asked, and without a
// camera of the photo's size the answer is "not in the map"; so it is wherever a whole panorama
// with as many inliers wouldn't be believed. Time grows with the nodes (about 5 ms each).
// `left_out` as for LocatePanorama. Thread-safe, deterministic. The map has an appearance layer
// (WS_CHECK).
Answer LocalizePhoto(const MapIndex& index, const cv::Mat& grey,
                     const std::optional<Camera>& camera, const PanoramaQueryOptions& options,
                     const std::vector<bool>& left_out = {});

}  // namespace waystone
