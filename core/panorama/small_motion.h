// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/panorama/row_images.h"

namespace waystone {

struct SmallMotionOptions {
  // Frequencies of the coarsest stage, 2 to 64; each stage doubles them. Fewer reach farther.
  int coarse_frequencies = 8;
  // Frequencies of the finest stage, 2 to 4096; those that the signatures don't have are left out.
  // More are finer, and most of the time is the finest stage's.
  int fine_frequencies = 64;
  // Gauss-Newton steps a stage, 1 to 50, and less where the last one was below so many of the
  // stage's columns, 0 to 1. Fewer are faster and stop short of the best fit.
  int steps = 4;
  double settled_pixels = 0.01;
  // Residuals beyond so many sigmas count less (Cauchy's weights), 1 to 10: bears what is
  // covered or has moved.
  double cauchy_sigmas = 2.4;
  // How much the nearness of landmarks varies around the circle, 0.01 to 10 of its mean: the prior
  // sigma of each of its four waves. More fits uneven rooms, less bears noise.
  double nearness_sigma = 0.5;
  // Residuals of neighbouring pixels are alike: how many pixels carry the information of one,
  // 1 to 1000. Scales the sigmas.
  double correlated_pixels = 20;

  void Check() const;  // throws MapError(kBadOptions)
};

// How the view changed from a to b. Angles are clockwise, as azimuths are.
struct SmallMotion {
  double turn_rad = 0;           // azimuths in b are those in a plus this
  Eigen::Vector2d motion{0, 0};  // step over the mean distance of landmarks, towards the front and
                                 // towards the right of a
  Eigen::Vector2d tilt_rad{0, 0};  // what is in front, what is on the right goes up by this
  double turn_sigma_rad = 0;
  Eigen::Matrix2d motion_covariance = Eigen::Matrix2d::Zero();
  double correlation = 0;  // of b brought back to a, with a: 1 is a perfect fit
};

// Another start, without motion, for stages from so many frequencies on.
struct StillStart {
  double turn_rad = 0;
  int frequencies = 32;
};

// Refines a turn by Gauss-Newton on what two signatures hold, coarse-to-fine over the frequencies,
// together with a small motion, the tilt of the camera and the gain. The landmarks' nearness around
// the circle is d(t) = 1 + c_1 cos t + c_2 sin t + c_3 cos 2t + c_4 sin 2t. With azimuth t and
// elevation e, turn h, motion (m, n), tilt (p, q), a point of a comes in b to
//   t + h + d(t) (m sin t - n cos t),
//   e + sin e cos e d(t) (m cos t + n sin t) + p cos t + q sin t.
// Meant for motions of less than about a tenth of the distance to the walls; beyond, the
// correlation tells. Where `still` is given, its first stage is refined from there as well, and
// whichever correlates more goes on. Both signatures must have the same rows (CheckFailure).
// Thread-safe.
SmallMotion RefineSmallMotion(const FourierSignature& a, const FourierSignature& b,
                              const ElevationBand& band, double turn_rad,
                              const SmallMotionOptions& options,
                              const std::optional<StillStart>& still = {});

}  // namespace waystone
