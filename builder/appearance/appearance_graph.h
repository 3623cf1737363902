// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/appearance/panorama_poses.h"

// Last step of the appearance layer: of panoramas with their poses become nodes and edges.
namespace waystone {

struct AppearanceGraph {
  AppearanceLayer layer;
  std::vector<AppearanceSampleFrame> samples;
};

// Nodes, edges and the count of what was dropped; the panoramas' pictures and features move into
// the nodes.
AppearanceGraph MakeAppearanceGraph(TakenPanoramas taken, const PanoramaPoses& poses,
                                    const AppearanceOptions& options);

}  // namespace waystone
