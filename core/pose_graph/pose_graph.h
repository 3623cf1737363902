// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/base/options.h"
#include "core/geometry/pose2.h"

namespace waystone {

// A measured relation between two poses of a graph.
struct PoseEdge {
  int a = 0;  // indices of poses
  int b = 0;
  Pose2 a_from_b;             // as measured
  double position_sigma = 1;  // standard deviation of x and of y, in units of a_from_b, above 0
  double heading_sigma_rad = 0.1;  // above 0
  bool loop = false;               // may be altogether wrong
  // Edges of one group measured lengths in one unknown unit: their x and y are multiplied by the
  // group's scale, which is estimated. Group 0 is in the graph's unit. Distances of signatures
  // (Fernandez et al. 2011, eq. 2) are such lengths: a group is a map, where maps are joined. A
  // build has one group: its sequences have their steps in one unit.
  int scale_group = 0;
};

struct PoseGraphOptions {
  double loop_loss = 3.0;
  double reject_beyond = 3.4;
  double log_scale_sigma = 0.5;
  int max_iterations = 100;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"loop_loss", &PoseGraphOptions::loop_loss, Closed(0.1, 100), "",
                    "Number of sigmas beyond which a loop edge is downweighted (Cauchy loss). "
                    "Higher values trust loops more; lower values tolerate more wrong loops, but "
                    "require a better initial estimate."},
        OptionField{"reject_beyond", &PoseGraphOptions::reject_beyond, Closed(1, 1000), "",
                    "Loop edges with a residual of more than this many sigmas after the robust "
                    "optimisation are removed. 3.4 keeps 99 % of correct loops if their sigmas are "
                    "correct."},
        OptionField{"log_scale_sigma", &PoseGraphOptions::log_scale_sigma, Closed(0.001, 10), "",
                    "When maps are joined: prior standard deviation of the logarithm of a map's "
                    "scale. Without it, maps whose scale isn't metric would shrink to a point. A "
                    "build has one scale for all sequences."},
        OptionField{"max_iterations", &PoseGraphOptions::max_iterations, Closed(1, 1000), "",
                    "Maximum number of steps per optimisation."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

struct PoseGraphResult {
  std::vector<Pose2> poses;    // those of the start where nothing is known
  std::vector<double> scales;  // by group; the first is 1
  std::vector<bool> rejected;  // by edge: loop edges that were taken out
};

// The poses that fit the edges best in the least squares sense, from `start` (graph_from_pose).
// First with a robust loss on loop edges that narrows down to loop_loss, then without those that it
// rejects. The pose with the lowest index in each connected part keeps its place. Runs on the
// calling thread only; the same input gives the same bytes. Thread-safe. Throws
// MapError(kBadOptions) for options out of range; edges that name a missing pose, one pose twice,
// or have sigmas of 0 are programmer's errors.
PoseGraphResult OptimisePoseGraph(const std::vector<Pose2>& start,
                                  const std::vector<PoseEdge>& edges,
                                  const PoseGraphOptions& options = {});

}  // namespace waystone
