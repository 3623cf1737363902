// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/base/options.h"
#include "core/panorama/row_images.h"

namespace waystone {

struct SmallMotionOptions {
  int coarse_frequencies = 8;
  int fine_frequencies = 64;
  int steps = 4;
  double settled_pixels = 0.01;
  double cauchy_sigmas = 2.4;
  double nearness_sigma = 0.5;
  double correlated_pixels = 20;

  static constexpr auto Fields(const auto& use) {
    using O = SmallMotionOptions;
    return use(
        OptionField{"coarse_frequencies", &O::coarse_frequencies, Closed(2, 64), "",
                    "Number of frequencies of the coarsest stage; each further stage doubles their "
                    "number. Fewer frequencies converge from farther away."},
        OptionField{"fine_frequencies", &O::fine_frequencies, Closed(2, 4096), "",
                    "Number of frequencies of the finest stage, at most those of the signatures. "
                    "More frequencies are more accurate; the finest stage takes most of the time."},
        OptionField{"steps", &O::steps, Closed(1, 50), "steps",
                    "Number of Gauss-Newton steps per stage. Fewer steps are faster, but may stop "
                    "before the best fit."},
        OptionField{"settled_pixels", &O::settled_pixels, Closed(0, 1), "px",
                    "A stage ends when a step is smaller than this, in pixels of that stage (its "
                    "columns)."},
        OptionField{"cauchy_sigmas", &O::cauchy_sigmas, Closed(1, 10), "sigmas",
                    "Residuals beyond this many sigmas are downweighted (Cauchy), which makes the "
                    "estimate robust to parts of the scene that are occluded or have moved."},
        OptionField{"nearness_sigma", &O::nearness_sigma, Closed(0.01, 10), "",
                    "Prior standard deviation of each of the four waves by which the inverse "
                    "distance of landmarks varies around the circle, relative to its mean. Higher "
                    "values fit uneven rooms; lower values tolerate more noise."},
        OptionField{"correlated_pixels", &O::correlated_pixels, Closed(1, 1000), "px",
                    "Number of neighbouring pixels whose correlated residuals carry the "
                    "information of one; scales the sigmas."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// How the view changed from a to b. Angles are clockwise, as azimuths are.
struct SmallMotion {
  double turn_rad = 0;           // azimuths in b are those in a plus this
  Eigen::Vector2d motion{0, 0};  // step over the mean distance of landmarks, towards the front and
                                 // towards the right of a
  double turn_sigma_rad = 0;
  Eigen::Matrix2d motion_covariance = Eigen::Matrix2d::Zero();
  double correlation = 0;  // of b brought back to a, with a: 1 is a perfect fit
};

// A second initial value, without motion, for stages from `frequencies` on.
struct StillStart {
  double turn_rad = 0;
  int frequencies = 32;
};

// Refines a turn by Gauss-Newton on the images of two signatures, coarse-to-fine over the
// frequencies, together with a small motion, the tilt of the camera and the gain. The landmarks'
// nearness around the circle is d(t) = 1 + c_1 cos t + c_2 sin t + c_3 cos 2t + c_4 sin 2t. With
// azimuth t and elevation e, turn h, motion (m, n), tilt (p, q), a point of a comes in b to
//   t + h + d(t) (m sin t - n cos t),
//   e + sin e cos e d(t) (m cos t + n sin t) + p cos t + q sin t.
// Meant for motions of less than about a tenth of the distance to the walls; beyond that, the
// correlation drops. Where `still` is given, its first stage is refined from there as well, and the
// better correlated result is continued. Both signatures must have the same rows (CheckFailure).
// Thread-safe.
SmallMotion RefineSmallMotion(const FourierSignature& a, const FourierSignature& b,
                              const ElevationBand& band, double turn_rad,
                              const SmallMotionOptions& options,
                              const std::optional<StillStart>& still = {});

}  // namespace waystone
