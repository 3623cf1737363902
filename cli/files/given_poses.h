// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/poses/options.h"

namespace waystone {

// What `waystone build` says of the poses that it is given.
struct PoseFlags {
  std::string file;  // empty: no poses
  std::string frame = "map";
  std::string unit = "unknown";
  std::string body_from_camera = {};  // "x y z qx qy qz qw"; empty where the poses are the camera's
  double max_gap_s = 0.2;
  // Two images and the distance of their cameras in metres, which the poses are scaled by; empty
  // where they keep their scale.
  std::vector<std::string> scale_by = {};
};

// The poses of a file (ReadPoseFile) by name, time or number of an image, times the camera's place
// on the body that they are of. Throws MapError: as ReadPoseFile; kBadRequest for poses without
// rotations, numbered ones of several sources, or two images of --scale-by that have no poses or
// one and the same; kUsage for a unit, a transform or a distance that isn't one.
GivenPoses ReadGivenPoses(const PoseFlags& flags, int sources);

// What of that can be told without the file. Throws MapError(kUsage).
void CheckPoseFlags(const PoseFlags& flags);

}  // namespace waystone
