// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/appearance/panorama_poses.h"

// Last step of the appearance layer: makes nodes and edges from panoramas with their poses.
namespace waystone {

struct AppearanceGraph {
  AppearanceLayer layer;
  std::vector<AppearanceSampleFrame> samples;
};

// Nodes, edges and the number of dropped panoramas; the panoramas' pictures and features move into
// the nodes. Deterministic; thread-safe.
AppearanceGraph MakeAppearanceGraph(TakenPanoramas taken, const PanoramaPoses& poses,
                                    const AppearanceOptions& options);

}  // namespace waystone
