// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/options.h"
#include "core/homography/homography.h"

namespace waystone {

// Points of one plane that two calibrated cameras see: a in the reference camera, b in a view, both
// on the image plane z = 1 of their camera (x right, y down, z forward). Four pairs or more.
struct PlaneSighting {
  int plane = 0;  // 0 to planes - 1
  int view = 0;   // 0 to views - 1
  PointPairs points;
};

struct SpaceOptions {
  double point_sigma = 0.002;
  int seeds = 16;
  int max_steps = 30;
  double rival_sigmas = 4;
  double rival_angle_rad = 0.2;
  double max_normal_sigma_rad = 0.06;
  double max_distance_sigma = 0.06;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"point_sigma", &SpaceOptions::point_sigma, Closed(1e-5, 0.1), "",
                    "Standard deviation of a coordinate of a point in a view, in the image plane z "
                    "= 1. Higher values trust small motions less."},
        OptionField{"seeds", &SpaceOptions::seeds, Closed(1, 1000), "",
                    "Number of sightings, those with the most parallax, whose decompositions are "
                    "tried. More sightings find the common motion among more wrong homographies."},
        OptionField{"max_steps", &SpaceOptions::max_steps, Closed(1, 1000), "",
                    "Number of refinement steps."},
        OptionField{"rival_sigmas", &SpaceOptions::rival_sigmas, Closed(0, 100), "",
                    "A solution whose error is within this many sigmas of the best one's leaves "
                    "the choice open. Higher values make more planes ambiguous."},
        OptionField{"rival_angle_rad", &SpaceOptions::rival_angle_rad, Closed(0.01, 1.5), "rad",
                    "Two solutions whose normals differ by more than this count as different."},
        OptionField{
            "max_normal_sigma_rad", &SpaceOptions::max_normal_sigma_rad, Closed(0.001, 1), "rad",
            "Maximum standard deviation of the normal of a plane that counts as determined."},
        OptionField{"max_distance_sigma", &SpaceOptions::max_distance_sigma, Closed(0.001, 1), "",
                    "Maximum standard deviation of the distance of a plane that counts as "
                    "determined, as a share of the distance."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Why a plane's place isn't known.
enum class SpaceError {
  kNone,
  kNoParallax,  // the camera hardly moved between its views, compared with their noise
  kAmbiguous,   // another normal explains its views as well, such as the other one of a homography
  kUncertain,   // its normal or distance has too large a sigma
};
std::string_view NameOf(SpaceError error);  // "none", "no_parallax", "ambiguous", "uncertain"

// A plane n . X = d of the reference camera's frame; n points away from the camera.
struct PlaneInSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 0;          // d > 0 in the estimate's unit; 0 where nothing is known
  double normal_sigma_rad = 0;  // standard deviation, worst direction
  double distance_sigma = 0;    // of the distance, as a share of it; 0 for the unit plane
  SpaceError error = SpaceError::kNoParallax;
};

// X_view = rotation X_reference + translation.
struct ViewMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // in the estimate's unit
};

struct SpaceEstimate {
  std::vector<PlaneInSpace> planes;
  std::vector<std::optional<ViewMotion>> views;  // nothing where no motion was found
  int unit_plane = -1;                           // its distance is 1; -1 where nothing is known
  double sigmas = 0;  // root mean square error of the points over point_sigma
};

// The planes that a reference camera and several views of it saw, in space. Each homography H = R +
// t n^T / d of two views has up to two decompositions in front of both cameras (Faugeras and
// Lustman 1988; here by Ma, Soatto, Kosecka and Sastry 2004, alg. 5.2). Each is tried: its motion
// puts the other planes of its view into space, these the other views, and so on; all planes of a
// view share R and t, all views of a plane n and d, so that the decomposition that explains most is
// the right one. All are then refined together by robust least squares on the points' transfer.
// Distances are relative: that of one plane is the unit. Deviations account for the points' noise
// only, not for a wrong calibration or surfaces that aren't flat. Deterministic; thread-safe.
SpaceEstimate FindPlanesInSpace(int planes, int views, std::span<const PlaneSighting> sightings,
                                const SpaceOptions& options = {});

}  // namespace waystone
