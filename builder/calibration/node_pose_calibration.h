// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/poses/add_node_poses.h"
#include "localizer/appearance/panorama_query_options.h"

namespace waystone {

// Measures the errors of answers about panoramas in the map's pose layer
// (PoseLayer::verified_errors, appearance_errors): each sample with a pose is localized as if its
// node weren't in the map, and the answer is compared with its given pose, whose own noise is
// therefore included. They stay unknown with fewer than 8 such answers. Counts them in `report`.
// Deterministic on any number of threads.
void MeasureNodePoseErrors(const std::vector<AppearanceSampleFrame>& samples,
                           const PanoramaQueryOptions& options, MapData& map,
                           NodePoseReport& report);

}  // namespace waystone
