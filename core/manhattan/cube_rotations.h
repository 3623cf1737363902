// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

namespace waystone {

// The 24 rotations that take the axes of a cube to axes of the cube. The first is the identity.
// This function and all below are pure; thread-safe.
const std::array<Eigen::Matrix3d, 24>& CubeRotations();

// Of the 24 descriptions rig_from_axes C of a Manhattan frame, the one nearest to a previous one:
// how axes are followed through a sequence, so that only true jumps are left (turns of the camera
// by more than 45 degrees between two frames can't be determined from the axes).
Eigen::Matrix3d NearestOfCube(const Eigen::Matrix3d& rig_from_axes,
                              const Eigen::Matrix3d& previous);

// The smallest angle between two frames whose axes may be numbered and signed differently, rad, in
// [0, 1.1].
double CubeAngle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

// Largest angle between the axes of two frames under the assignment of axes that minimises it, rad.
double WorstAxisAngle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

}  // namespace waystone
