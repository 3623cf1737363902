// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "builder/frames/progress.h"
#include "builder/orientation/traversability.h"

namespace waystone {

// A node as seen by loop closing; in order of frame ids.
struct LoopNode {
  OrientedFeatures features;
  int map = -1;  // nodes of one map, unless below 0, are not compared
};

// Loop closures (sec. III-C.2): nodes with the orientation of an earlier node and enough verified
// correspondences with it. Earlier nodes are ranked by the matches of their strongest features, and
// the best are verified. Nodes of different sequences may differ by a quarter turn in their axes.
// Ordered by (a, b). Runs on TBB's threads; deterministic. Throws MapError(kInterrupted).
std::vector<OrientationEdge> FindLoops(std::span<const LoopNode> nodes,
                                       const OrientationLoopOptions& options,
                                       const TraversabilityOptions& traversability,
                                       ProgressReporter& progress);

}  // namespace waystone
