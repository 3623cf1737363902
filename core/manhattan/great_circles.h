// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/options.h"
#include "core/camera/rig.h"
#include "core/manhattan/segments.h"

namespace waystone {

// A segment as an arc on the unit sphere around the rig's centre. All vectors are unit vectors of
// the rig's frame, perpendicular to each other: normal = middle x along.
struct GreatCircle {
  Eigen::Vector3d normal;  // of the plane through the centre and the line, l = x1 x x2 (sec. II-A)
  Eigen::Vector3d middle;  // ray through the middle of the arc
  Eigen::Vector3d along;   // tangent of the arc at its middle
  double length_rad = 0;   // angle between the rays of the end points
  double end_sigma_rad = 0;  // standard deviation of an end point's ray across the arc
  int camera = 0;            // index in the rig
  ImageSegment segment;      // where it was seen, distorted pixels of that camera
};

struct GreatCircleOptions {
  double end_sigma_px = 0.5;
  double max_sag_px = 1.0;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"end_sigma_px", &GreatCircleOptions::end_sigma_px, Closed(0.05, 5), "px",
                    "Standard deviation of a segment's end point, perpendicular to the segment. "
                    "Higher values trust short segments less."},
        OptionField{
            "max_sag_px", &GreatCircleOptions::max_sag_px, Closed(0.1, 20), "px",
            "Maximum distance between a segment's midpoint and the great circle through its ends. "
            "A segment that is straight in a distorted image is not straight in the world."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The arcs of one camera's segments. The camera's position in the rig is ignored: directions of
// lines don't depend on it. Segments whose ends have the same ray, and those that sag more than
// max_sag_px, are left out. Deterministic; thread-safe.
std::vector<GreatCircle> FindGreatCircles(const Rig& rig, int camera,
                                          std::span<const ImageSegment> segments,
                                          const GreatCircleOptions& options = {});

}  // namespace waystone
