// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/trajectory/trajectory_error.h"

namespace waystone {

// Reads a trajectory: a CSV file (by its extension) with the columns x, y and, where known, time_s
// and theta_rad or qx, qy, qz, qw; else a TUM file, "time x y z qx qy qz qw" a line, '#' comments.
// x and y are the ground. A quaternion's heading is that of a camera's gaze, its z axis. Throws
// MapError: kFileUnreadable; kBadRequest naming the line for what isn't a trajectory.
Trajectory ReadTrajectory(const std::filesystem::path& path);

}  // namespace waystone
