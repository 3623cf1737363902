// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/visual_odometry.h"

// Places that a camera came back to, beyond the paper (its future work).
namespace waystone {

struct LoopOptions {
  // Panoramas of one sequence that are nearer than this in it are no loop, 2 to 100000. Fewer find
  // small loops, and what lies side by side.
  int min_gap = 30;
  // Magnitudes a row that candidates are found by, 1 to 4096, at most what the signatures have. The
  // lowest change slowly, so that a place is still known some steps beside it.
  int k1 = 16;
  // A candidate is at most this share as far as two panoramas usually are, 0.05 to 1. More finds
  // more loops; each candidate costs a compass.
  double max_distance_share = 0.6;
  // Candidates a panorama, 1 to 20, each min_gap from the others.
  int candidates = 2;
  // Headings less certain than this close no loop, radians, 0.001 to 1.
  double max_sigma_rad = 0.03;
  // Other candidates that must say the same, 0 to 20, among those of panoramas at most
  // neighbourhood (1 to 1000) before or behind in both passes: rooms that look alike seldom do so
  // over a stretch and from the same side.
  int min_supporters = 2;
  int neighbourhood = 5;
  // What counts as the same: headings to this, radians, 0.001 to 1, and places to this many steps,
  // 0.1 to 100, plus a third of the way between them.
  double agreement_rad = 0.1;
  double agreement_steps = 2;
  // Deviation of the place of a loop: a share of its length, 0.01 to 10, and so many steps, 0.01
  // to 100.
  double length_sigma = 0.3;
  double steps_sigma = 0.5;

  void Check() const;  // throws MapError(kBadOptions)
};

struct LoopClosure {
  std::vector<PanoramaRelation> loops;  // verified, ascending by (a, b)
  std::vector<PoseEdge> edges;          // of each
  int candidates = 0;                   // that the compass was asked about
  int certain = 0;                      // of them, with a certain heading and a known step
};

// A stretch of panoramas that were taken one after the other: [first, last).
struct PanoramaStretch {
  int first = 0;
  int last = 0;
};

// Finds loops within and between stretches, whose odometry `ways` are. A loop is verified in three
// ways: the compass must fit a small motion between the two panoramas with a certain heading;
// neighbours of both must say the same of each other (odometry between them); and whoever optimises
// the graph rejects what doesn't fit the rest. The length of a loop is the compass's step over the
// landmarks' distance in the unit of the steps near it. `odometry` brings the compass;
// `before_each` is as for FollowPanoramas. The same for any number of threads.
LoopClosure CloseLoops(const std::vector<FourierSignature>& signatures, const ElevationBand& band,
                       const std::vector<PanoramaStretch>& stretches,
                       const std::vector<VisualOdometry>& trajectories,
                       const VisualOdometryOptions& odometry, const LoopOptions& options = {},
                       const std::function<void()>& before_each = {});

}  // namespace waystone
