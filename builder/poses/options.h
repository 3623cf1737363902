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
  // right, y down, z forward; a panorama's z points to its middle column. May be called from any
  // thread.
  std::function<std::optional<Eigen::Isometry3d>(const Sequence&, const FrameInfo&)> of_image;
};

// How given poses are used. Constants of the method, not options: maps don't record them.
struct PoseOptions {
  double keypoint_sigma_px = 0.7;  // of a keypoint, the error of the given poses included
  int neighbours = 4;              // keyframes before and after in which a feature is searched for
  double near_px = 3;  // radius around a plane's feature, as a homography maps it, to search in
  // Largest distance of a feature's descriptors in two views, as a share of the largest possible
  // one.
  double max_descriptor_distance = 0.5;
  // Smallest share of the matches of neighbouring keyframes that must agree with the poses, or they
  // are refused.
  double min_consistent = 0.5;
  double min_posed = 0.5;  // smallest share of the keyframes, and of the panoramas, with a pose
  // Number of steps between consecutive panoramas whose motion is compared with the poses, evenly
  // spread. A few ms each.
  int compared_steps = 100;
  // Largest difference in the turn of such a step. Poses must show a turn of twice as much.
  double max_turn_error_rad = 0.05;
  double max_direction_error_rad = 0.5;  // and its direction
  MatchOptions match;
  EpipolarOptions epipolar{.max_error_px = 1.5};
  DepthOptions depth;
};

}  // namespace waystone
