// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/poses/options.h"

namespace waystone {

// What the flags of `waystone build` say about the poses that it is given.
struct PoseFlags {
  std::string file;  // empty: no poses
  std::string frame = "map";
  std::string unit = "unknown";
  std::string body_from_camera = {};  // "x y z qx qy qz qw"; empty where the poses are the camera's
  double max_gap_s = 0.2;
  // Two images and the distance of their cameras in metres, by which the poses are scaled; empty
  // where they keep their scale.
  std::vector<std::string> scale_by = {};
};

// The poses of a file (ReadPoseFile) by name, time or number of an image, each multiplied by the
// camera's pose on the body that they are of. Throws MapError: as ReadPoseFile; kBadRequest for
// poses without rotations, numbered poses with several sources, or two images of --scale-by that
// have no poses or the same position; kUsage as CheckPoseFlags.
GivenPoses ReadGivenPoses(const PoseFlags& flags, int sources);

// Checks what can be checked without the file. Throws MapError(kUsage) for an invalid unit,
// transform or distance, and for a scale of poses in metres.
void CheckPoseFlags(const PoseFlags& flags);

}  // namespace waystone
