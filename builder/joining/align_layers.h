// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/pose2.h"

namespace waystone {

// One panorama in two layers.
struct PoseInLayers {
  Pose2 in_to;
  Pose2 in_from;
  double position_sigma = 0;  // of in_to, in the unit of `to`; or of in_from, in that of `from`
  bool answered_in_from = false;
};

// A similarity on the ground: to_from, whose translation is in the unit of `to`.
struct LayerChange {
  double scale = 1;
  Pose2 to_from;

  Pose2 operator()(const Pose2& pose) const {
    return to_from * Pose2{scale * pose.x, scale * pose.y, pose.theta_rad};
  }
};

// The change of layer that most panoramas agree with, fitted to all that do. Odometry bends: a
// panorama may be off by a share of its distance from the one with which a change was tried. With
// `same_unit` the scale is 1. Nothing where fewer than three panoramas or less than half of them
// agree. Deterministic; thread-safe.
std::optional<LayerChange> AlignLayers(const std::vector<PoseInLayers>& poses, bool same_unit);

}  // namespace waystone
