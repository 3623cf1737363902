// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/trajectory/trajectory_error.h"

namespace waystone {

// Reads a trajectory: a CSV file (by its extension) with the columns x and y, and optionally time_s
// and theta_rad or qx, qy, qz, qw; otherwise a TUM file, "time x y z qx qy qz qw" per line, with
// '#' comments. x and y span the ground. A quaternion's heading is the direction of the camera's z
// axis. Throws MapError: kFileUnreadable; kBadRequest, naming the line, for anything else.
Trajectory ReadTrajectory(const std::filesystem::path& path);

}  // namespace waystone
