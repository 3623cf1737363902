// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/panorama/fourier_signature.h"
#include "core/panorama/small_motion.h"
#include "core/panorama/warping_search.h"

namespace waystone {

// Headings and directions are counter-clockwise seen from above, in [-pi, pi]: the yaw of b in the
// world is that of a plus the heading.

struct PhaseCompassOptions {
  // Weight of a row's frequency: (m_a m_b)^power of its magnitudes, 0 to 1. 0 is the paper's
  // convolution of the phases alone, in which noise counts like edges; 1 the plain cross-spectrum,
  // in which few strong waves decide.
  double power = 0.5;
  // Frequencies used, 2 to 4096, from 1. Fewer see through a larger motion, more are sharper.
  int frequencies = 64;
  // Headings tried around the circle, 16 to 65536, before the best is refined.
  int steps = 512;
  // How far a runner-up lies off, radians, 0.01 to 3.
  double separation_rad = 0.35;

  void Check() const;  // throws MapError(kBadOptions)
};

struct CompassPeak {
  double heading_rad = 0;
  double score = 0;  // share of the weights that agree: 1 is a pure turn, 0 nothing in common
};

struct PhaseCompass {
  CompassPeak best;
  CompassPeak runner_up;  // the best that lies off by separation_rad at least
  double sharpness = 0;   // how much the best scores above the runner-up
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
  // How far a runner-up of the warping search lies off, radians, 0.01 to 3.
  double separation_rad = 0.35;
  // Costs of the warping search, summed over the columns, by which a hypothesis becomes e times
  // less likely, 0.01 to 100. More states larger sigmas.
  double cost_per_e = 0.6;
  // The warping's own sigma, radians, 0.001 to 0.5: its columns and its model are coarse.
  double warping_sigma_rad = 0.03;
  // The small motion is believed where it explains this share of a, 0 to 1, and turns within
  // agreement_rad (0.001 to 1) of the warping search.
  double min_correlation = 0.5;
  double agreement_rad = 0.1;
  // Frequencies of the coarsest stage from the phases' heading, 2 to 64: that heading is exact for
  // a pure turn, and what is covered misleads coarse stages.
  int still_frequencies = 32;
  // A small motion of fewer of its own sigmas is none, 0 to 100: the heading then comes from
  // the phases alone, which what is covered or noisy disturbs less.
  double still_sigmas = 6;
  // How unevenly far the landmarks are, 0 to 1: the small motion takes them for equally far, and
  // errs by this share of step over distance. More states larger sigmas of larger steps.
  double uneven_depth = 0.15;
  // Directions of motion less certain than this are left out, radians, 0.01 to 1.8.
  double max_motion_sigma_rad = 0.8;

  void Check() const;  // throws MapError(kBadOptions)
};

// The direction from a to b, in a's frame: 0 is a's front, pi / 2 its left.
struct MotionDirection {
  double direction_rad = 0;
  double sigma_rad = 0;
  // The step over the mean distance of the landmarks; known for small motions alone.
  std::optional<double> step_per_distance;
};

struct CompassHeading {
  double heading_rad = 0;
  double sigma_rad = 0;       // with the chance of being altogether wrong in it
  double sharpness = 0;       // how much more a column costs under the runner-up, of the cost of
                              // uncorrelated columns
  double runner_up_rad = 0;   // the best heading that lies off by separation_rad at least
  bool small_motion = false;  // refined by the small motion; else by the warping search alone
  std::optional<MotionDirection> motion;  // when it is determined to max_motion_deviation_rad
};

// The heading of b against a when b may have moved, by up to about half the distance to the walls:
// warping search; refined by the small motion where that fits; and where that motion is none, the
// paper's compass.
CompassHeading RelativeHeading(const FourierSignature& a, const FourierSignature& b,
                               const CompassOptions& options = {});

}  // namespace waystone
