// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "core/base/options.h"
#include "core/geometry/pose2.h"
#include "core/panorama/visual_compass.h"
#include "core/pose_graph/pose_graph.h"

// Where a panoramic camera went, from signatures only (Fernandez et al. 2011, sec. IV-A).
namespace waystone {

// How steps and headings are estimated.
struct VisualOdometryOptions {
  int k1 = 64;
  int max_span = 4;
  CompassOptions compass;  // its band is replaced by that of the signatures
  double length_sigma = 0.5;
  double span_sigma = 1.0;
  double max_sigma_rad = 0.2;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"k1", &VisualOdometryOptions::k1, Closed(1, 4096), "",
                    "Number of magnitudes per row over which the distance between two panoramas "
                    "(eq. 2) is summed, at most those of the signatures. Distances grow more "
                    "slowly than the trajectory: with fewer frequencies they stay proportional for "
                    "longer, but depend more on how near the walls are."},
        OptionField{"max_span", &VisualOdometryOptions::max_span, Closed(1, 64), "panoramas",
                    "Each panorama is compared with those 1, 2, 4, ... before it, up to this. "
                    "Headings over several steps don't accumulate the errors of single steps. Each "
                    "comparison costs one compass estimate."},
        OptionGroup{"compass", &VisualOdometryOptions::compass},
        OptionField{"length_sigma", &VisualOdometryOptions::length_sigma, Closed(0.01, 10), "",
                    "Standard deviation of a step's position, relative to its length. It is larger "
                    "than the error of a single step because the errors of neighbouring steps are "
                    "correlated. Higher values let loops bend the trajectory more."},
        OptionField{"span_sigma", &VisualOdometryOptions::span_sigma, Closed(0.01, 10), "",
                    "The same as length_sigma, for longer spans, whose lengths are the sums of "
                    "their steps."},
        OptionField{"max_sigma_rad", &VisualOdometryOptions::max_sigma_rad, Closed(0.01, 3), "rad",
                    "Steps whose headings are less certain than this are counted as uncertain."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// What two panoramas say about each other.
struct PanoramaRelation {
  int a = 0;  // indices, a < b
  int b = 0;
  double distance = 0;  // D of eq. (2)
  CompassHeading heading;
  Pose2 a_from_b;
};

struct VisualOdometry {
  std::vector<Pose2> poses;             // first_from_panorama; the first is the origin
  std::vector<PanoramaRelation> steps;  // from each panorama to the next
  std::vector<PoseEdge> edges;          // of the steps, then of the longer spans
  double mean_step = 0;                 // length, in the unit of eq. (2)
  int uncertain = 0;                    // steps
};

// D^{a,b} of eq. (2) over the first k1 columns of the magnitudes.
double SignatureDistance(const FourierSignature& a, const FourierSignature& b, int k1);

// The trajectory of a camera that took these panoramas one after the other, in the unit of eq. (2).
// A step is D long (eq. 2). The paper's robot looks where it goes, so its steps go along the
// heading (eqs. 3 and 4); here they go in the direction of motion that the compass found, since
// cameras need not look along their trajectory, and along the mean of both headings only where it
// found none. A camera that stood still (small motion without a direction) didn't move, though
// noise gives it a distance. Headings add up (eq. 5), and those over longer spans correct the sum
// (least squares). `before_each`, where given, is called before each comparison, from any thread
// and by several at a time; what it throws ends the work and is passed on.
// The same for any number of threads. The signatures have one size (CheckFailure).
VisualOdometry FollowPanoramas(const std::vector<FourierSignature>& signatures,
                               const ElevationBand& band, const VisualOdometryOptions& options = {},
                               const std::function<void()>& before_each = {});

}  // namespace waystone
