// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace waystone {

// A point that may lie on a plane, with its uncertainty.
struct UncertainPoint {
  Eigen::Vector3d x;
  Eigen::Vector3d along;  // one sigma along its ray
  double across = 0;      // one sigma in all directions
};

// The plane n . x = d.
struct FittedPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  // of (n, d)
  // How far the surface is from a plane: standard deviation of the points beyond their own.
  double flatness = 0;
  int inliers = 0;
};

// Robust least squares (Cauchy) on the points' distances from the plane, in their sigmas. Nothing
// for fewer than `min_points` inliers or points on one line. Deterministic; thread-safe.
std::optional<FittedPlane> FitPlane(const std::vector<UncertainPoint>& points, int min_points);

// A depth and its standard deviation, as a share of the depth.
struct UncertainDepth {
  double depth = 0;
  double sigma = 0;
};

// How far along a unit ray in the camera's frame the plane is; nothing where it isn't ahead. Pure;
// thread-safe.
std::optional<UncertainDepth> MeetPlane(const Eigen::Isometry3d& frame_from_camera,
                                        const Eigen::Vector3d& ray, const FittedPlane& plane);

// Flips the plane n . x = d where needed so that its normal points away from the camera.
// Thread-safe.
void TurnAway(const Eigen::Isometry3d& frame_from_camera, Eigen::Vector3d& normal,
              double& distance);

}  // namespace waystone
