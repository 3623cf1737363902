// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/homography/plane_in_space.h"

// The joint refinement of planes and motions: internal to core/homography. All functions are
// deterministic; thread-safe.
namespace waystone {

// Planes m . X = 1 (m = n / d) and motions, as far as they are known. The scale is free: m / s and
// s t give the same homographies.
struct SpaceModel {
  std::vector<std::optional<Eigen::Vector3d>> planes;
  std::vector<std::optional<ViewMotion>> views;
  double cost = 0;  // robust, of all sightings; unknown ones count as wrong ones
};

// Derivatives of a point's error, in sigmas, by the plane's m, a rotation vector on the left of the
// rotation, and the translation.
Eigen::Matrix<double, 2, 9> SpaceJacobian(const ViewMotion& motion, const Eigen::Vector3d& m,
                                          const Eigen::Vector2d& a, double sigma);

// Robust cost of a model: sum of squared sigmas, each point's at most kLargestCost.
double ComputeCost(const SpaceModel& model, std::span<const PlaneSighting> sightings,
                   const SpaceOptions& options);

// Levenberg-Marquardt over all known planes and motions; gives the model its cost.
void RefineSpace(SpaceModel& model, std::span<const PlaneSighting> sightings,
                 const SpaceOptions& options, int steps);

// Covariances of the planes' m with the length of `unit_plane`'s fixed, scaled up where the errors
// are larger than point_sigma; nothing for unknown ones.
std::vector<std::optional<Eigen::Matrix3d>> PlaneCovariances(
    const SpaceModel& model, std::span<const PlaneSighting> sightings, const SpaceOptions& options,
    int unit_plane);

}  // namespace waystone
