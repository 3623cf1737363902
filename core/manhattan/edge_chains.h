// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/manhattan/segments.h"

namespace waystone {

// A chain of edge pixels, each beside the next.
using EdgeChain = std::vector<cv::Point>;

// Links the edge pixels (CV_8UC1, not 0) of an image into chains: the link function of sec. II-A. A
// chain ends where it has no unused neighbour; at a fork it continues as straight as it can. Each
// pixel is in one chain. Deterministic; thread-safe.
std::vector<EdgeChain> LinkEdges(const cv::Mat& edges);

// The straight pieces of chains, which are cut recursively at the pixel farthest from the chord,
// fitted by least squares; those shorter than `min_length_px` are left out. Deterministic;
// thread-safe.
std::vector<ImageSegment> StraightPieces(const std::vector<EdgeChain>& chains, double max_bend_px,
                                         double min_length_px);

}  // namespace waystone
