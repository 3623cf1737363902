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

// Localizes a perspective photo in a map of panoramas. Its features vote for nodes
// (NodeFeatureIndex) and become rays by its camera; the nodes with the most votes are matched with
// it, and those with the most matches verified by relative poses, as for panoramas; two must agree
// in the photo's heading (that of its optical axis). Nodes without features can't be queried, and
// without a camera of the photo's size the answer is "not in the map", as it is wherever a whole
// panorama with as many inliers wouldn't be believed. `left_out` as for LocatePanorama.
// Thread-safe; deterministic except for the deadline. The map has an appearance layer (WS_CHECK).
Answer LocalizePhoto(const MapIndex& index, const cv::Mat& grey,
                     const std::optional<Camera>& camera, const PanoramaQueryOptions& options,
                     const Deadline& deadline = {}, const std::vector<bool>& left_out = {});

}  // namespace waystone
