// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/options.h"
#include "core/two_view/bearings.h"

namespace waystone {

struct RelativeOptions {
  double max_error_rad = 0.003;
  double confidence = 0.999;
  int max_samples = 600;
  int min_samples = 30;
  int max_steps = 15;
  int min_inliers = 10;
  double max_log10_chance = -6.0;
  double max_sigma_rad = 0.01;
  double max_rival = 0.9;
  double rival_angle_rad = 0.01;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_error_rad", &RelativeOptions::max_error_rad, Closed(1e-5, 0.1), "rad",
                    "Maximum error of an inlier (EpipolarError). Higher values accept blurred and "
                    "poorly calibrated images, but also more wrong matches."},
        OptionField{"confidence", &RelativeOptions::confidence, Closed(0.5, 0.999999), "",
                    "Probability that at least one sample consists of inliers only."},
        OptionField{"max_samples", &RelativeOptions::max_samples, Closed(1, 100'000), "",
                    "Maximum number of samples; bounds the running time."},
        OptionField{"min_samples", &RelativeOptions::min_samples, Closed(1, 100'000), "",
                    "Minimum number of samples."},
        OptionField{"max_steps", &RelativeOptions::max_steps, Closed(1, 100), "",
                    "Maximum number of refinement steps."},
        OptionField{
            "min_inliers", &RelativeOptions::min_inliers, Closed(5, 10'000), "",
            "Minimum number of correspondences for a rotation; the paper uses 10 (sec. III-C)."},
        OptionField{
            "max_log10_chance", &RelativeOptions::max_log10_chance, Closed(-300, 0), "",
            "Maximum number of motions, as a power of ten, that the same number of unrelated "
            "matches would be expected to fit. Lower values refuse more motions."},
        OptionField{"max_sigma_rad", &RelativeOptions::max_sigma_rad, Closed(1e-5, 1), "rad",
                    "Maximum standard deviation of the rotation about its worst-known direction."},
        OptionField{
            "max_rival", &RelativeOptions::max_rival, Closed(0.5, 1), "",
            "A plane allows two motions. The pose is ambiguous if the second one explains at least "
            "this share of what the best one explains. Lower values make more poses ambiguous."},
        OptionField{"rival_angle_rad", &RelativeOptions::rival_angle_rad, Closed(0.001, 1), "rad",
                    "Minimum angle between the two motions at which they count as different."},
        OptionField{"seed", &RelativeOptions::seed, AnyValue(), "", "Seed of the samples."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Why two rigs have no relative rotation.
enum class RelativeError {
  kNone,
  kFewInliers,  // fewer correspondences fit one motion than are required
  kChance,      // as many would fit by accident
  kUncertain,   // they don't determine the rotation
  kPlanar,      // they lie on a plane, which another motion explains as well: see `rival`
};
// "none", "few_inliers", "chance", "uncertain", "planar".
std::string_view NameOf(RelativeError error);

// The motion between two rigs from matched rays: x_b = b_from_a x_a + s * translation.
struct RelativePose {
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  // Unit vector, b's frame; meaningless when the rigs hardly moved.
  Eigen::Vector3d translation = Eigen::Vector3d::UnitZ();
  // Of the rotation vector w, b's frame, rad^2: R_true = exp(w) R. The identity where nothing is
  // known.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::vector<int> inliers;  // rows of the matched rays, ascending
  // log10 of the number of motions that as many matches would fit if none were right
  // (LogFalseAlarms); 0 for one or more.
  double log10_chance = 0;
  int samples = 0;  // that were drawn
  // The other motion that a plane allows (Faugeras and Lustman 1988), where these matches can't
  // distinguish it from the best one; the covariance holds for either.
  struct Rival {
    Eigen::Matrix3d b_from_a;
    Eigen::Vector3d translation;
  };
  std::optional<Rival> rival;
  RelativeError error = RelativeError::kFewInliers;

  bool accepted() const { return error == RelativeError::kNone; }
  // Accepted, but for the choice between it and its rival.
  bool one_of_two() const { return error == RelativeError::kPlanar; }
  double sigma_rad() const;
};

// Error of a match under E = [t]x R, rad: |x_b^T E x_a| over the length of its gradient by both
// rays (Sampson's distance on the sphere). 0 for a perfect match; for small errors about the angle
// by which each ray would have to move. Pure; thread-safe.
double EpipolarError(const Eigen::Matrix3d& b_from_a, const Eigen::Vector3d& translation,
                     const Eigen::Vector3d& a, const Eigen::Vector3d& b);

// The essential matrix over rays in any direction (sec. II-B.2): RANSAC over samples of five
// matches, with each promising model refined on its inliers by robust least squares on rotation and
// direction. Always gives the best motion it found; `error` says whether to believe it.
// Deterministic; thread-safe.
RelativePose FindRelativePose(const MatchedRays& rays, const RelativeOptions& options = {});

}  // namespace waystone
