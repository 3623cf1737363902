// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/options.h"

namespace waystone {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A point of the world and the ray on which a camera sees it.
struct PointSighting {
  Eigen::Vector3d point;                            // in the world
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  // its uncertainty: one sigma in its worst
                                                    // direction ...
  double across = 0;                                // ... and one sigma in all directions
  Eigen::Vector3d ray;                              // unit, in the camera
  double sigma_rad = 0;                             // standard deviation of the ray's direction
  double weight = 1;  // below 1 for sightings that aren't independent of each other
};

struct AbsolutePoseOptions {
  double max_sigmas = 5;
  int min_inliers = 8;
  int max_samples = 300;
  double confidence = 0.999;
  int max_steps = 12;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    using Self = AbsolutePoseOptions;
    return use(OptionField{"max_sigmas", &Self::max_sigmas, Closed(1, 20), "",
                           "Maximum error of a match that supports a pose, in its standard "
                           "deviations; less for a match whose point is uncertain.",
                           OptionUse::kInternal},
               OptionField{"min_inliers", &Self::min_inliers, AtLeast(4), "",
                           "Minimum number of matches with distinct features of the query for a "
                           "pose. Higher values give fewer, more certain poses."},
               OptionField{"max_samples", &Self::max_samples, Closed(1, 100'000), "",
                           "Maximum number of samples of three matches; bounds the running time.",
                           OptionUse::kInternal},
               OptionField{"confidence", &Self::confidence, Open(0, 1), "",
                           "Probability that at least one sample consists of inliers only.",
                           OptionUse::kInternal},
               OptionField{"max_steps", &Self::max_steps, Closed(1, 1000), "",
                           "Number of refinement steps.", OptionUse::kInternal},
               OptionField{"seed", &Self::seed, AnyValue(), "", "Random seed of the samples.",
                           OptionUse::kInternal});
  }
};

struct AbsolutePose {
  Eigen::Isometry3d world_from_camera = Eigen::Isometry3d::Identity();
  // Of the position and of a small rotation about the world's axes, exp(delta) world_from_camera:
  // from the Jacobian of the inliers, scaled by their residuals.
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<int> inliers;  // rows of the sightings, ascending
  double variance = 1;       // of the residuals; 1 is as expected
};

// The pose of a calibrated camera among known points: LO-RANSAC over three matches (P3P of Ke and
// Roumeliotis 2017, by OpenCV), refined by robust least squares (Cauchy) over all inliers. Errors
// are weighed by the deviations of ray and point, and poses are scored by the likelihood of the
// matches, to which an uncertain point contributes less. Nothing where fewer than min_inliers fit,
// or where they don't determine the pose. Deterministic; thread-safe.
std::optional<AbsolutePose> FindAbsolutePose(std::span<const PointSighting> sightings,
                                             const AbsolutePoseOptions& options);

// Refines a pose on the sightings that agree with it, as above.
std::optional<AbsolutePose> RefineAbsolutePose(std::span<const PointSighting> sightings,
                                               const Eigen::Isometry3d& world_from_camera,
                                               const AbsolutePoseOptions& options);

}  // namespace waystone
