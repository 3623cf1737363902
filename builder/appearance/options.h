// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "builder/appearance/describe_panorama.h"
#include "builder/appearance/loop_closure.h"
#include "builder/appearance/redundancy.h"
#include "builder/appearance/visual_odometry.h"
#include "core/pose_graph/pose_graph.h"

namespace waystone {

// Everything the layer is made with.
struct AppearanceOptions {
  DescribeOptions describe;
  VisualOdometryOptions odometry;
  LoopOptions loops;
  PoseGraphOptions graph;
  RedundancyOptions redundancy;
  // Whether loops are looked for at all; without them the poses are those of the odometry.
  bool close_loops = true;
  // Largest share of a sequence's frames that may be unusable, 0 to 1. Beyond, the sequence is
  // refused: its steps would be of very different lengths.
  double max_skipped_share = 0.5;
  // Panoramas whose features are handed out whole, for calibrating the verdict, 0 to 100,000:
  // spread evenly over all. They take about 0.2 MB each while the map is built.
  int max_samples = 60;

  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
