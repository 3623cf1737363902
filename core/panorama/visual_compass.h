// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/base/options.h"
#include "core/panorama/fourier_signature.h"
#include "core/panorama/small_motion.h"
#include "core/panorama/warping_search.h"

namespace waystone {

// Headings and directions are counter-clockwise seen from above, in [-pi, pi]: the yaw of b in the
// world is that of a plus the heading.

struct PhaseCompassOptions {
  double power = 0.5;
  int frequencies = 64;
  int steps = 512;
  double separation_rad = 0.35;

  static constexpr auto Fields(const auto& use) {
    using O = PhaseCompassOptions;
    return use(
        OptionField{
            "power", &O::power, Closed(0, 1), "",
            "Exponent of the weight (m_a m_b)^power of a frequency in a row, from its magnitudes. "
            "0 is the paper's convolution of phases only, which weights noise like edges; 1 is the "
            "plain cross-spectrum, which a few strong waves dominate."},
        OptionField{"frequencies", &O::frequencies, Closed(2, 4096), "",
                    "Number of frequencies used, starting at 1. Fewer frequencies tolerate larger "
                    "motions; more give a sharper peak."},
        OptionField{"steps", &O::steps, Closed(16, 65536), "steps",
                    "Number of headings tried around the circle before the best one is refined."},
        OptionField{"separation_rad", &O::separation_rad, Closed(0.01, 3), "rad",
                    "Minimum angle between the best heading and a runner-up."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

struct CompassPeak {
  double heading_rad = 0;
  double score = 0;  // share of the weights that agree: 1 is a pure turn, 0 nothing in common
};

struct PhaseCompass {
  CompassPeak best;
  CompassPeak runner_up;  // the best at least separation_rad away
  double sharpness = 0;   // score of the best less that of the runner-up
};

// The paper's compass (sec. III-B): the convolution of the phases over all turns, by eq. (1), with
// weights; the peak refined between the steps. For panoramas of one place. Both signatures must
// have the same rows (CheckFailure). Thread-safe, as all here.
PhaseCompass TurnByPhases(const FourierSignature& a, const FourierSignature& b,
                          const PhaseCompassOptions& options = {});

struct CompassOptions {
  PhaseCompassOptions phases{};
  // The band of the signatures (SignatureOptions::band).
  ElevationBand band = SignatureOptions{}.band;
  WarpingOptions warping{};
  SmallMotionOptions small_motion{};
  double separation_rad = 0.35;
  double cost_per_e = 0.6;
  double warping_sigma_rad = 0.03;
  double min_correlation = 0.5;
  double agreement_rad = 0.1;
  int still_frequencies = 32;
  double still_sigmas = 6;
  double uneven_depth = 0.15;
  double max_motion_sigma_rad = 0.8;

  static constexpr int kUnlistedMembers = 1;  // the band, which is that of the signatures
  static constexpr auto Fields(const auto& use) {
    using O = CompassOptions;
    return use(
        OptionGroup{"phases", &O::phases}, OptionGroup{"warping", &O::warping},
        OptionGroup{"small_motion", &O::small_motion},
        OptionField{"separation_rad", &O::separation_rad, Closed(0.01, 3), "rad",
                    "Minimum angle between the warping search's best result and a runner-up."},
        OptionField{"cost_per_e", &O::cost_per_e, Closed(0.01, 100), "",
                    "Difference in cost of the warping search, summed over the columns, at which a "
                    "hypothesis is e times less likely. Higher values report larger sigmas."},
        OptionField{"warping_sigma_rad", &O::warping_sigma_rad, Closed(0.001, 0.5), "rad",
                    "Standard deviation of the warping search itself, due to its coarse columns "
                    "and model."},
        OptionField{"min_correlation", &O::min_correlation, Closed(0, 1), "",
                    "The small-motion estimate is accepted if it explains at least this share of "
                    "the first panorama."},
        OptionField{"agreement_rad", &O::agreement_rad, Closed(0.001, 1), "rad",
                    "The small-motion estimate is accepted if its rotation differs from that of "
                    "the warping search by at most this."},
        OptionField{
            "still_frequencies", &O::still_frequencies, Closed(2, 64), "",
            "Number of frequencies of the coarsest stage when started from the phases' heading. "
            "That heading is exact for a pure rotation, while occlusions mislead coarse stages."},
        OptionField{
            "still_sigmas", &O::still_sigmas, Closed(0, 100), "sigmas",
            "A motion smaller than this many of its sigmas counts as no motion. The heading then "
            "comes from the phases alone, which occlusion and noise disturb less."},
        OptionField{"uneven_depth", &O::uneven_depth, Closed(0, 1), "",
                    "Relative variation of the landmarks' distances. The small-motion estimate "
                    "assumes equal distances; its error is this share of the ratio of step to "
                    "distance. Higher values report larger sigmas for larger steps."},
        OptionField{"max_motion_sigma_rad", &O::max_motion_sigma_rad, Closed(0.01, 1.8), "rad",
                    "Directions of motion that are less certain than this are omitted."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The direction from a to b, in a's frame: 0 is a's front, pi / 2 its left.
struct MotionDirection {
  double direction_rad = 0;
  double sigma_rad = 0;
  // The step over the mean distance of the landmarks; known only for small motions.
  std::optional<double> step_per_distance;
};

struct CompassHeading {
  double heading_rad = 0;
  double sigma_rad = 0;       // includes the chance of being altogether wrong
  double sharpness = 0;       // how much more a column costs under the runner-up, of the cost of
                              // uncorrelated columns
  double runner_up_rad = 0;   // the best heading at least separation_rad away
  bool small_motion = false;  // refined by the small motion; else from the warping search only
  std::optional<MotionDirection> motion;  // when it is determined to max_motion_sigma_rad
};

// The heading of b relative to a when b may have moved, by up to about half the distance to the
// walls: warping search; refined by the small motion where that fits; and where there was no
// motion, the paper's compass.
CompassHeading RelativeHeading(const FourierSignature& a, const FourierSignature& b,
                               const CompassOptions& options = {});

}  // namespace waystone
