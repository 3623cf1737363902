// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>

#include "builder/sources/source.h"
#include "core/camera_pose/inverse_depth.h"
#include "core/features/match.h"
#include "core/two_view/fundamental.h"
#include "schema/map_data.h"

namespace waystone {

// Where the images of a build were taken, by another program.
struct GivenPoses {
  std::string frame = "map";  // its name
  LengthUnit unit = LengthUnit::kUnknown;
  // frame_from_camera of an image of a sequence; nothing where it isn't known. The camera has x
  // right, y down, z forward; a panorama's looks ahead where its middle column does. Any thread.
  std::function<std::optional<Eigen::Isometry3d>(const Sequence&, const FrameInfo&)> of_image;
};

// How poses are taken into a map. Constants of the method, not options: maps don't record them.
struct PoseOptions {
  double keypoint_sigma_px = 0.7;  // of a keypoint, the error of the given poses included
  int neighbours = 4;              // keyframes before and after in which a feature is searched for
  double near_px = 3;  // of where a homography puts a plane's feature it is searched for in a view
  // Largest distance of a feature's descriptors in two views, as a share of what they can differ
  // by.
  double max_descriptor_distance = 0.5;
  // Smallest share of the matches of neighbouring keyframes that must agree with the poses, which
  // are refused otherwise.
  double min_consistent = 0.5;
  double min_posed = 0.5;  // smallest share of the keyframes, and of the panoramas, with a pose
  // Steps from a panorama to the next whose motion is compared with the poses, spread evenly over
  // all. A few ms each.
  int compared_steps = 100;
  // By how much the turn of such a step may differ. A turn of twice as much is one that poses must
  // show.
  double max_turn_error_rad = 0.05;
  double max_direction_error_rad = 0.5;  // and its direction
  MatchOptions match;
  EpipolarOptions epipolar{.max_error_px = 1.5};
  DepthOptions depth;
};

}  // namespace waystone
