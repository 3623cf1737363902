// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/panorama/visual_compass.h"
#include "core/pose_graph/pose_graph.h"

// Where a panoramic camera went, from signatures alone (Fernandez et al. 2011, sec. IV-A).
namespace waystone {

struct VisualOdometryOptions {
  // Magnitudes a row that the distance of two panoramas (eq. 2) is summed over, 1 to 4096, at most
  // what the signatures have. The distance grows more slowly than the trajectory: with all
  // frequencies hardly any more after a few steps, so that even steps come out even, and uneven
  // ones more even than they are. With few it follows the trajectory longer, and the nearness of
  // the walls more.
  int k1 = 64;
  // Each panorama is compared with as many before it as powers of 2 up to this, 1 to 64: headings
  // over several steps don't share the errors of those over one, and don't add up. Costs a compass
  // each.
  int max_span = 4;
  // The compass; its band is replaced by that of the signatures.
  CompassOptions compass;
  // Standard sigma of a step's place, in its lengths, 0.01 to 10. Errors of neighbouring steps
  // are alike, for the walls stay as near as they were: more than a single step is off by. More
  // lets loops bend the trajectory more.
  double length_sigma = 0.5;
  // The same for the longer spans, whose lengths are those of the steps in them, 0.01 to 10.
  double span_sigma = 1.0;
  // Steps whose headings are less certain are counted as uncertain, radians, 0.01 to 3.
  double max_sigma_rad = 0.2;

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

// The way of a camera that took these panoramas one after the other, in the unit of eq. (2).
// A step is D long (eq. 2). The paper's robot looks where it goes, so its steps go along the
// heading (eqs. 3 and 4); here they go where the compass saw the camera go, for cameras need not
// look along their trajectory, and along the middle of the turn only where it could not tell. A
// camera that stood still (small motion without a direction) didn't move, though noise gives it a
// distance. Headings add up (eq. 5), and those over longer spans correct the sum (least squares).
// `before_each`, where given, is called before each comparison, from any thread and by several at a
// time; what it throws ends the work and is passed on.
// The same for any number of threads. Signatures of one size (CheckFailure).
VisualOdometry FollowPanoramas(const std::vector<FourierSignature>& signatures,
                               const ElevationBand& band, const VisualOdometryOptions& options = {},
                               const std::function<void()>& before_each = {});

}  // namespace waystone
