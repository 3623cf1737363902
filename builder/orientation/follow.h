// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "builder/orientation/traversability.h"
#include "builder/orientation/view.h"

namespace waystone {

// Heading of a head in the building: 0 looks along x, pi / 2 along y; (-pi, pi]. Nothing for a
// frame without a rotation.
std::optional<double> HeadingOf(const OrientationFrame& frame);

// The axes of a frame as the map has them, and what following them renumbered.
struct FollowedFrame {
  std::optional<BuildingRotation> rotation;
  bool reliable = false;
  ManhattanFrame axes;  // numbered and signed as the building's
};

// Follows the building's axes through one sequence (sec. III-A). The first reliable frame settles
// them: the building's x is the axis nearest to its view ahead. From then on each frame gets, of
// the 24 ways to number its axes, the one nearest to the frame before. Where frames aren't
// reliable, or jump, the rotation between the features of two frames predicts the axes, and lines
// that disagree with it (a skewed room) aren't relied on. Of two frames that explain the lines
// alike (FrameTrouble::kRival, common where a single camera sees little but upright lines) the one
// that the prediction leads to is relied on. Not thread-safe; frames in order.
class AxesFollower {
 public:
  AxesFollower(const FollowOptions& options, const TraversabilityOptions& traversability,
               const ManhattanOptions& manhattan);

  FollowedFrame Follow(const OrientationViewPtr& view);

 private:
  struct Known {
    OrientationViewPtr view;
    Eigen::Matrix3d head_from_building;
    Eigen::Matrix3d covariance;  // of its rotation vector, head's frame
    bool reliable = false;
  };
  // The rotation of `view` by the features that it shares with the last known frame.
  std::optional<Known> Predict(const OrientationViewPtr& view) const;
  FollowedFrame Settle(const OrientationViewPtr& view, const ManhattanFrame& axes);
  // Of frames that explain the lines alike, the one that was predicted.
  FollowedFrame Choose(const OrientationViewPtr& view, Known predicted);
  FollowedFrame Carry(const OrientationViewPtr& view, std::optional<Known> predicted);

  FollowOptions options_;
  TraversabilityOptions traversability_;
  ManhattanOptions manhattan_;
  std::optional<Known> last_;
  int since_last_ = 0;  // frames
};

}  // namespace waystone
