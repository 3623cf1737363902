// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "core/base/options.h"

namespace waystone {

// A feature of an anchor camera as another camera of known pose sees it.
struct RaySighting {
  Eigen::Isometry3d camera_from_anchor = Eigen::Isometry3d::Identity();
  Eigen::Vector3d ray;   // unit, in that camera
  double sigma_rad = 0;  // standard deviation of the ray's direction
};

struct DepthOptions {
  double max_sigmas = 4;
  int min_sightings = 2;
  double min_inlier_share = 0.5;
  double max_relative_sigma = 0.3;
  double prior_sightings = 4;

  static constexpr auto Fields(const auto& use) {
    using Self = DepthOptions;
    return use(OptionField{"max_sigmas", &Self::max_sigmas, Closed(1, 20), "",
                           "Maximum error of a sighting that agrees with a depth, in its standard "
                           "deviations. Higher values tolerate less accurate poses.",
                           OptionUse::kInternal},
               OptionField{"min_sightings", &Self::min_sightings, AtLeast(1), "",
                           "Minimum number of keyframes, in addition to its own, that must agree "
                           "on a feature's depth.",
                           OptionUse::kInternal},
               OptionField{"min_inlier_share", &Self::min_inlier_share, Closed(0, 1), "",
                           "Minimum share of a feature's sightings that must agree on its depth.",
                           OptionUse::kInternal},
               OptionField{"max_relative_sigma", &Self::max_relative_sigma, OpenLow(0, 1), "",
                           "Maximum standard deviation of a depth, as a share of the depth.",
                           OptionUse::kInternal},
               OptionField{"prior_sightings", &Self::prior_sightings, Closed(0, 100), "",
                           "Weight of the expected noise, in sightings, with which a feature's own "
                           "residuals are averaged.",
                           OptionUse::kInternal});
  }
};

// Why a depth isn't known.
enum class DepthError {
  kNone,
  kTooFew,         // too few sightings
  kContradiction,  // they don't agree on a point on the ray ahead
  kUncertain,      // the cameras are too close together for it
};

struct DepthEstimate {
  DepthError error = DepthError::kTooFew;
  double depth = 0;           // along the anchor's unit ray, in the unit of the translations
  double relative_sigma = 0;  // standard deviation over depth
  int inliers = 0;            // sightings that agree
  double error2 = 0;          // sum of their squared errors, in squared sigmas
};

// The distance of a feature along its ray (unit, in the anchor camera) that most sightings agree
// on, poses held: inverse depth (Civera, Davison and Montiel 2008), one hypothesis a sighting,
// refined by Gauss-Newton over those that agree. Deterministic; thread-safe.
DepthEstimate EstimateDepth(const Eigen::Vector3d& anchor_ray,
                            std::span<const RaySighting> sightings, const DepthOptions& options);

}  // namespace waystone
