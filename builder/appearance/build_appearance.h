// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "builder/appearance/describe_frames.h"
#include "builder/appearance/loop_closure.h"
#include "builder/appearance/redundancy.h"
#include "builder/appearance/visual_odometry.h"
#include "builder/sources/source.h"
#include "core/pose_graph/pose_graph.h"
#include "schema/map_data.h"

namespace waystone {

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

// What the building of the layer did.
struct AppearanceReport {
  int frames = 0;
  int skipped = 0;                         // frames that are no usable panorama
  std::vector<std::string> skipped_names;  // "012.jpg: cause", the first 20 of them
  int panoramas = 0;
  int steps = 0;            // from a panorama to the next
  int uncertain = 0;        // of them, those whose heading is uncertain
  int loop_candidates = 0;  // that the compass was asked about
  int loops_certain = 0;    // of them, with a certain heading
  int loops_supported = 0;  // of them, that neighbours agree with
  int loops_rejected = 0;   // of them, that don't fit the graph
  int dropped = 0;          // redundant panoramas
  // A pose a panorama, also those that were dropped, by odometry alone and in the end.
  std::vector<Pose2> odometry;
  std::vector<Pose2> poses;
  double decode_s = 0;    // summed over threads
  double describe_s = 0;  // summed over threads
  double odometry_s = 0;
  double loops_s = 0;
  double graph_s = 0;
  double calibrate_s = 0;  // of the verdict, by BuildMap
  double total_s = 0;      // wall clock

  // Whether so many steps are uncertain that the trajectory can't be relied on: rooms are too small
  // for the steps, or panoramas too dark, too plain or too far apart.
  bool IsTrajectoryDoubtful() const;
};

// A panorama as it was read, also where it was left out as redundant.
struct AppearanceSampleFrame {
  FourierSignature signature;
  BearingFeatures features;  // all that were found; none where the layer keeps none
  Pose2 pose;                // layer_from_node
  int node = -1;             // index in the layer's nodes; -1 when it was left out
};

struct AppearanceResult {
  AppearanceLayer layer;
  std::vector<AppearanceSampleFrame> samples;
  std::vector<Sequence> sequences;  // a source each, ids from 1
  AppearanceReport report;
};

// Called one call at a time, from any thread, with the stage ("panoramas", "odometry", "loops",
// "poses") and how far it is; a build stops with MapError(kInterrupted) when it returns false.
using AppearanceProgress = std::function<bool(const std::string& stage, int done, int total)>;

// The appearance layer of sequences of panoramas: signatures (eq. 1), odometry (eqs. 2 to 5), loop
// closure, pose graph, and redundant nodes left out. Sequences are tied together by the loops
// between them; one without any is laid out below the others. The layer's unit of length is that of
// eq. (2): how many metres it is isn't known. Frames that can't be used (not decodable, of another
// size, all black, no panorama) are skipped, counted and named. Threads are those of the calling
// task arena; the layer doesn't depend on their number.
// Throws MapError(kBadOptions); kBadSource for no source, and for one with fewer than 2 usable
// panoramas, with more than max_skipped_share unusable ones, or whose panoramas show other
// elevations than those before it.
AppearanceResult BuildAppearanceLayer(const std::vector<Source*>& sources,
                                      const AppearanceOptions& options,
                                      const AppearanceProgress& progress = {});

}  // namespace waystone
