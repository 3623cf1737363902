// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/camera/camera.h"
#include "localizer/appearance/panorama_query_options.h"
#include "localizer/index/map_index.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/deadline.h"

namespace waystone {

// Where was this perspective photo taken, asked of a map of panoramas? Its features vote for nodes
// (NodeFeatureIndex) and become rays by its camera; the most voted nodes are matched with it,
// those with the most matches verified by relative poses, as panoramas are, of which two must agree
// in the photo's heading (its optical axis's). Nodes without features can't be asked, and without a
// camera of the photo's size the answer is "not in the map"; so it is wherever a whole panorama
// with as many inliers wouldn't be believed. `left_out` as for LocatePanorama. Thread-safe,
// deterministic but for the deadline. The map has an appearance layer (WS_CHECK).
Answer LocalizePhoto(const MapIndex& index, const cv::Mat& grey,
                     const std::optional<Camera>& camera, const PanoramaQueryOptions& options,
                     const Deadline& deadline = {}, const std::vector<bool>& left_out = {});

}  // namespace waystone
