// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/features/features.h"

namespace waystone {

// Features of `count` pictures of a synthetic building that no map shows: its textures have a seed
// of their own. The same on any number of threads; thread-safe.
std::vector<Features> RenderNegatives(int count, const FeatureOptions& options);

// The same. The process caches those of the last call, since rendering them takes as long as the
// rest of a small map: a worker that builds one map after the other renders them once. Thread-safe.
std::vector<Features> CachedNegatives(int count, const FeatureOptions& options);

// `count` whole panoramas (CV_8UC1, width_px by width_px / 2) of the same building. The same on any
// number of threads; thread-safe.
std::vector<cv::Mat> RenderedPanoramas(int count, int width_px);

}  // namespace waystone
