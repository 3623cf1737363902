// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "builder/orientation/options.h"
#include "schema/layers/orientation/orientation_layer.h"

namespace waystone {

// A frame as the test takes it.
struct OrientedFeatures {
  const BearingFeatures* features = nullptr;
  const OrientationFrame* frame = nullptr;
};

// How two frames are related.
struct Traversal {
  bool connected = false;  // the space between them is visually traversable
  RelativePose pose;       // b_from_a
  int matches = 0;         // verified by the essential matrix
  // Angle between the essential matrix's rotation and the nearest of R1 P R2^T, P exchanging the
  // axes; nothing unless both frames are reliable. rad
  std::optional<double> disagreement_rad;
  // Heading of the motion in the building, from a to b, (-pi, pi]; nothing when the rig hardly
  // moved, or b has no rotation. rad
  std::optional<double> motion_rad;
  // Mean motion of the features around the vertical, rad; above 0 to the left (the rig turned to
  // the right). 0 without matches.
  double flow_rad = 0;
};

// Sec. II-B.2: the essential matrix over the features of both frames, its rotation against R_c =
// R_1 R_2^T (fig. 1), and enough correspondences. Unlike in the paper, R_c is compared up to the
// numbers and signs of the axes: a frame that is off by a quarter turn is no contradiction. Where a
// frame's axes aren't reliable, only the essential matrix decides. Deterministic; thread-safe.
Traversal TestTraversability(const OrientedFeatures& a, const OrientedFeatures& b,
                             const TraversabilityOptions& options = {});

}  // namespace waystone
