// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string_view>

namespace waystone {

// A line of a TUM trajectory, "time x y z qx qy qz qw": world_from_camera, metres, seconds.
struct TumPose {
  double time_s = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // as written, not normalised
};

// Nothing for a line that isn't eight finite numbers. FormatPoses writes such lines. Pure;
// thread-safe.
std::optional<TumPose> ParseTumPose(std::string_view line);

}  // namespace waystone
