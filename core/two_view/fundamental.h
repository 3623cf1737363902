// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/base/options.h"

namespace waystone {

struct EpipolarOptions {
  double max_error_px = 2.0;
  double confidence = 0.999;
  int max_samples = 1000;
  double planar_share = 0.9;

  static constexpr auto Fields(const auto& use) {
    using Self = EpipolarOptions;
    return use(
        OptionField{"max_error_px", &Self::max_error_px, Above(0), "px",
                    "Maximum Sampson error of an inlier. Higher values accept more matches, but "
                    "also more chance matches."},
        OptionField{"confidence", &Self::confidence, Open(0, 1), "",
                    "Probability that at least one sample consists of inliers only.",
                    OptionUse::kInternal},
        OptionField{"max_samples", &Self::max_samples, Closed(1, 100'000), "",
                    "Maximum number of samples of seven matches, however low the inlier ratio; "
                    "bounds the running time."},
        OptionField{
            "planar_share", &Self::planar_share, Closed(0, 1), "",
            "If one homography explains this share of the inliers, the scene counts as planar or "
            "the motion as a pure rotation, and only the homography's inliers count."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The epipolar geometry of two images without calibration.
struct EpipolarFit {
  // The fundamental matrix: x_b^T F x_a = 0 for homogeneous pixels.
  Eigen::Matrix3d fundamental = Eigen::Matrix3d::Zero();
  std::vector<int> inliers;  // rows, ascending
  // Whether a homography explains the inliers as well, so that the fundamental matrix isn't
  // determined; `inliers` then are the homography's.
  bool planar = false;
};

// The fundamental matrix that most of the pairs a[i], b[i] (px) support, by USAC with a sigma
// consensus (MAGSAC); nothing for fewer than eight pairs or where none fits eight. Deterministic;
// thread-safe. `a` and `b` have the same size (WS_CHECK).
std::optional<EpipolarFit> FindEpipolarGeometry(std::span<const Eigen::Vector2d> a,
                                                std::span<const Eigen::Vector2d> b,
                                                const EpipolarOptions& options);

// How unlikely it is that matches at random positions in a width x height image give an epipolar
// geometry with this many inliers: -ln of the expected number of such geometries, at least 0
// (LogFalseAlarms for samples of seven, which have up to three geometries; alpha is the share of
// the image's area that the largest band of that width covers). 0 is chance. Pure; thread-safe.
double EpipolarSignificance(int matches, int inliers, double max_error_px, int width, int height);

// Sampson error of a pair, px: the first-order distance to the nearest pair that fits exactly
// (Hartley and Zisserman, eq. 11.9).
double SampsonError(const Eigen::Matrix3d& fundamental, const Eigen::Vector2d& x_a,
                    const Eigen::Vector2d& x_b);

}  // namespace waystone
