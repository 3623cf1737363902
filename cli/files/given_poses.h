// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "builder/poses/options.h"

namespace waystone {

// What `waystone build` says of the poses that it is given.
struct PoseFlags {
  std::string file;  // empty: no poses
  std::string frame = "map";
  std::string unit = "unknown";
  std::string body_from_camera;  // "x y z qx qy qz qw"; empty where the poses are the camera's
  double max_gap_s = 0.2;
};

// The poses of a file (ReadPoseFile) by name, time or number of an image, times the camera's place
// on the body that they are of. Throws MapError: as ReadPoseFile; kBadRequest for poses without
// rotations, numbered ones of several sources, a unit or a transform that isn't one.
GivenPoses ReadGivenPoses(const PoseFlags& flags, int sources);

}  // namespace waystone
