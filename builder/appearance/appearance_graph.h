// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/take_panoramas.h"

// Last step of BuildAppearanceLayer: of panoramas with their poses become nodes and edges.
namespace waystone {

// Nodes, edges and the count of what was dropped; the panoramas' pictures and features move into
// the nodes. `ways` has each stretch's odometry, `poses` each panorama's pose.
struct AppearanceGraph {
  AppearanceLayer layer;
  std::vector<AppearanceSampleFrame> samples;
};

AppearanceGraph MakeAppearanceGraph(TakenPanoramas taken,
                                    const std::vector<VisualOdometry>& trajectories,
                                    const LoopClosure& closure, const std::vector<Pose2>& poses,
                                    const AppearanceOptions& options);

}  // namespace waystone
