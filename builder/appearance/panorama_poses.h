// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/options.h"
#include "builder/appearance/take_panoramas.h"
#include "builder/frames/progress.h"

namespace waystone {

// Where panoramas were taken, and the evidence for it.
struct PanoramaPoses {
  std::vector<VisualOdometry> trajectories;  // of each stretch
  LoopClosure closure;                       // with the loops that fit the graph
  std::vector<Pose2> odometry;               // layer_from_panorama, by odometry only
  std::vector<Pose2> poses;                  // layer_from_panorama, in the end
  int steps = 0;                             // from one panorama to the next
  int uncertain = 0;                         // of them, those with an uncertain heading
  int loops_rejected = 0;                    // that don't fit the graph
  double odometry_s = 0;
  double loops_s = 0;
  double graph_s = 0;
};

// The poses of panoramas, first by odometry and then by odometry and loops together. Reports the
// stages "odometry", "loops" and "poses". Deterministic on any number of threads.
PanoramaPoses EstimatePanoramaPoses(const TakenPanoramas& taken, const AppearanceOptions& options,
                                    ProgressReporter& progress);

}  // namespace waystone
