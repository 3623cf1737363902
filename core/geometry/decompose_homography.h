// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace waystone {

// How a camera moved beside a plane n . x_a = 1 (in units of the plane's distance): x_b = b_from_a
// x_a + translation, so that H = b_from_a + translation n^T takes a's rays to points of the plane
// to b's. (-translation, -normal) gives the same H: the caller takes the sign that puts the plane
// ahead.
struct PlaneMotion {
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // over the plane's distance
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();       // of unit length; 0 for a pure rotation
};

// The two motions of a homography between calibrated cameras (rays, or points of the image plane z
// = 1), up to the sign of translation and normal (Faugeras and Lustman 1988, in the form of Ma,
// Soatto, Kosecka and Sastry 2004, alg. 5.2). The homography's scale is free, its sign isn't: it
// must take rays ahead of a to rays ahead of b. One motion without translation and normal where the
// eigenvalues of H^T H (middle one 1) differ by less than `rotation_tolerance`. Nothing for a
// matrix that isn't finite or has rank one. Pure; thread-safe.
std::vector<PlaneMotion> DecomposeHomography(const Eigen::Matrix3d& b_from_a,
                                             double rotation_tolerance = 1e-12);

}  // namespace waystone
