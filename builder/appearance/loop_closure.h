// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/visual_odometry.h"
#include "core/base/options.h"

// Places that a camera came back to, beyond the paper (its future work).
namespace waystone {

// How loops are found and verified.
struct LoopOptions {
  int min_gap = 30;
  int k1 = 16;
  double max_distance_share = 0.6;
  int candidates = 2;
  double max_sigma_rad = 0.03;
  int min_supporters = 2;
  int neighbourhood = 5;
  double agreement_rad = 0.1;
  double agreement_steps = 2;
  double trajectory_share = 1.0 / 3;
  double length_sigma = 0.3;
  double steps_sigma = 0.5;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{
            "min_gap", &LoopOptions::min_gap, Closed(2, 100'000), "panoramas",
            "Two panoramas of one sequence form a loop only if they are at least this many "
            "panoramas apart. Lower values find smaller loops, but also pairs of adjacent places."},
        OptionField{"k1", &LoopOptions::k1, Closed(1, 4096), "",
                    "Number of magnitudes per row used to find candidates, at most those of the "
                    "signatures. Low frequencies change slowly, so that a place is still "
                    "recognised a few steps away."},
        OptionField{
            "max_distance_share", &LoopOptions::max_distance_share, Closed(0.05, 1), "",
            "Maximum distance of a candidate, relative to the typical distance between two "
            "panoramas. Higher values find more loops; each candidate costs one compass estimate."},
        OptionField{"candidates", &LoopOptions::candidates, Closed(1, 20), "",
                    "Number of candidates per panorama, each at least min_gap from the others."},
        OptionField{"max_sigma_rad", &LoopOptions::max_sigma_rad, Closed(0.001, 1), "rad",
                    "Candidates whose heading is less certain than this don't close a loop."},
        OptionField{
            "min_supporters", &LoopOptions::min_supporters, Closed(0, 20), "",
            "Number of other candidates among neighbouring panoramas that must agree. Different "
            "rooms that look alike rarely do so over several panoramas and from the same side."},
        OptionField{"neighbourhood", &LoopOptions::neighbourhood, Closed(1, 1000), "panoramas",
                    "How far before or after a candidate a supporting one may be, in both passes."},
        OptionField{"agreement_rad", &LoopOptions::agreement_rad, Closed(0.001, 1), "rad",
                    "Headings that differ by at most this agree."},
        OptionField{"agreement_steps", &LoopOptions::agreement_steps, Closed(0.1, 100), "steps",
                    "Positions agree if they differ by at most this, plus trajectory_share of the "
                    "trajectory between them."},
        OptionField{"trajectory_share", &LoopOptions::trajectory_share, Closed(0, 1), "",
                    "Allowed odometry error between two loops, as a share of the trajectory "
                    "between them; added to agreement_steps.",
                    OptionUse::kInternal},
        OptionField{"length_sigma", &LoopOptions::length_sigma, Closed(0.01, 10), "",
                    "Standard deviation of a loop's position as a share of the loop's length; "
                    "added to steps_sigma."},
        OptionField{"steps_sigma", &LoopOptions::steps_sigma, Closed(0.01, 100), "steps",
                    "Part of the standard deviation of a loop's position that doesn't depend on "
                    "its length; added to length_sigma."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

struct LoopClosure {
  std::vector<PanoramaRelation> loops;  // verified, ascending by (a, b)
  std::vector<PoseEdge> edges;          // of each
  int candidates = 0;                   // given to the compass
  int certain = 0;                      // of them, with a certain heading and a known step
};

// A stretch of panoramas that were taken one after the other: [first, last).
struct PanoramaStretch {
  int first = 0;
  int last = 0;
};

// Finds loops within and between stretches, whose odometry is `trajectories`. A loop is verified in
// three ways: the compass must fit a small motion between the two panoramas with a certain heading;
// neighbours of both must agree with it (by the odometry between them); and the optimisation of the
// graph rejects what doesn't fit the rest. The length of a loop is the compass's step over the
// landmarks' distance in the unit of the steps near it. `odometry` has the compass options;
// `before_each` is as for FollowPanoramas. Deterministic on any number of threads (it uses TBB's).
LoopClosure CloseLoops(const std::vector<FourierSignature>& signatures, const ElevationBand& band,
                       const std::vector<PanoramaStretch>& stretches,
                       const std::vector<VisualOdometry>& trajectories,
                       const VisualOdometryOptions& odometry, const LoopOptions& options = {},
                       const std::function<void()>& before_each = {});

}  // namespace waystone
