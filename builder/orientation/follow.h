// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "builder/orientation/traversability.h"
#include "builder/orientation/view.h"

namespace waystone {

// Heading of a rig in the building: 0 looks along x, pi / 2 along y; (-pi, pi]. Nothing for a frame
// without a rotation. Pure; thread-safe.
std::optional<double> HeadingOf(const OrientationFrame& frame);

// The axes of a frame as the map has them, after following has renumbered them.
struct FollowedFrame {
  std::optional<BuildingRotation> rotation;
  bool reliable = false;
  bool anchored = false;  // the rotation is the building's, not perhaps another by a quarter turn
  ManhattanFrame axes;    // numbered and signed as the building's
};

// Follows the building's axes through one sequence (sec. III-A). A frame of axes that is far better
// than any other, or one that several images in a row agree on, settles them: the building's x is
// the axis nearest to the view ahead. From then on the features carry the rotation from image to
// image. Of a plane's two motions the one is taken that continues the camera's previous turn. Where
// the lines have axes near the prediction, the two are fused by their covariances, which makes an
// image's rotation reliable; lines in other directions (a skewed room) leave it as predicted. Where
// neither features nor a short gap connect an image to those before it, its quarter turn is not
// guessed: it and those after it have no reliable rotation until a common view with an earlier
// image settles it. Not thread-safe; frames in order.
class AxesFollower {
 public:
  AxesFollower(const FollowOptions& options, const TraversabilityOptions& traversability,
               const ManhattanOptions& manhattan);

  FollowedFrame Follow(const OrientationViewPtr& view);

 private:
  // A frame whose rotation is known, but perhaps for its quarter turn.
  struct Known {
    OrientationViewPtr view;
    int frame = 0;
    Eigen::Matrix3d rig_from_building;
    Eigen::Matrix3d covariance;  // of its rotation vector, rig's frame
    int votes = 1;               // frames that agreed, before the axes are settled
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();  // turn from a frame to the next, rad
  };
  // The rotation of `view` by the features that it shares with a known frame.
  std::optional<Known> Predict(const Known& from, const OrientationViewPtr& view) const;
  // The axes of the view's lines near a prediction, if it has any.
  std::optional<ManhattanFrame> AxesNear(const OrientationViewPtr& view,
                                         const Known& predicted) const;
  FollowedFrame Settle(const OrientationViewPtr& view);
  FollowedFrame Carry(Known predicted);
  FollowedFrame TakeUp(const OrientationViewPtr& view);
  void AddAnchor(const Known& known);
  FollowedFrame Know(Known known, ManhattanFrame axes, bool reliable);
  std::optional<Known> Anchored(const OrientationViewPtr& view) const;

  FollowOptions options_;
  TraversabilityOptions traversability_;
  ManhattanOptions manhattan_;
  int frame_ = -1;
  std::vector<Known> guesses_;  // before the axes are settled: of the frame before
  std::optional<Known> last_;
  bool anchored_ = true;        // the quarter turn of last_ is the building's
  std::vector<Known> anchors_;  // the last of some frames whose quarter turn is
};

}  // namespace waystone
