// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localizer/appearance.h"

namespace waystone {

struct AppearanceCalibrationOptions {
  // Nodes that are asked for again, spread evenly over the layer, 1 to 100,000. More tell the model
  // better, and cost a query each, twice.
  int max_nodes = 60;
  // An answer within so many spacings of the truth is right, 0.1 to 100.
  double right_spacings = 2;
  // A node is asked for as if its surroundings weren't in the map: without the nodes within so many
  // spacings, 1 to 1000.
  double blank_spacings = 6;
  PanoramaQueryOptions query;
  AppearanceFitOptions fit;

  void Check() const;  // throws MapError(kBadOptions)
};

// The model of the appearance layer's verdict, fitted to answers of the map itself: each node is
// asked for without itself (leave one out), where the answer is right or wrong by its distance; and
// without all nodes near it, where any answer is wrong. `outside` are panoramas of what the map
// doesn't show. The model is for verified answers where the nodes keep features and the options
// verify, else for those by appearance alone. Throws MapError(kBadOptions); the map has an
// appearance layer (WS_CHECK). Deterministic on any number of threads.
AppearanceVerdict CalibrateAppearance(const MapIndex& index,
                                      const std::vector<PanoramaQuery>& outside,
                                      const AppearanceCalibrationOptions& options = {});

// A node as a query: its own signature, and its features where the options verify.
PanoramaQuery QueryOfNode(const MapIndex& index, int node, const PanoramaQueryOptions& options);

}  // namespace waystone
