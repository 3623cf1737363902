// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/base/options.h"
#include "core/panorama/row_images.h"

namespace waystone {

struct WarpingOptions {
  int columns = 120;
  int frequencies = 60;
  double max_shift_rad = 1.2;
  double max_scale = 4;
  int scales = 11;
  double shift_cost = 0.05;
  double upright_share = 0.5;
  double edge_softness = 1;
  double plain_share = 0.15;

  static constexpr auto Fields(const auto& use) {
    using O = WarpingOptions;
    return use(
        OptionField{
            "columns", &O::columns, Closed(24, 360), "columns",
            "Number of columns around the circle (an even number): the grid of rotations and "
            "directions of motion. More columns give a finer grid; time grows cubically."},
        OptionField{
            "frequencies", &O::frequencies, Closed(4, 4096), "",
            "Number of frequencies used, at most those of the signature; those beyond half the "
            "columns would alias. Fewer frequencies tolerate tilt and change; more are sharper."},
        OptionField{"max_shift_rad", &O::max_shift_rad, Closed(0.05, 1.5), "rad",
                    "Maximum change of a landmark's bearing due to the motion. Higher values cover "
                    "larger motions, but let unrelated columns match."},
        OptionField{"max_scale", &O::max_scale, Closed(1.1, 5), "",
                    "Maximum ratio of a landmark's distances before and after the motion."},
        OptionField{"scales", &O::scales, Closed(3, 41), "steps",
                    "Number of steps from 1 / max_scale to max_scale (an odd number). More steps "
                    "fit better; time grows linearly."},
        OptionField{"shift_cost", &O::shift_cost, Closed(0, 5), "",
                    "Cost per radian of shift, relative to the cost of uncorrelated columns. It "
                    "favours distant landmarks, which are more common in rooms."},
        OptionField{"upright_share", &O::upright_share, Closed(0, 1), "",
                    "Weight of vertical edges (door frames, corners) relative to horizontal ones "
                    "when columns are compared. Higher values resolve azimuths better; lower "
                    "values resolve distances better."},
        OptionField{"edge_softness", &O::edge_softness, Closed(0, 100), "",
                    "Edges of this strength, relative to the root mean square, count half as much "
                    "as the strongest ones. Lower values let faint edges count next to bright "
                    "windows; 0 doesn't compress edges."},
        OptionField{"plain_share", &O::plain_share, Closed(0, 10), "",
                    "Columns whose edges have this share of the mean square count half as much as "
                    "the most textured ones, since plain walls contain mostly noise."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The search's answer. Angles are clockwise, as azimuths are.
struct Warping {
  double turn_rad = 0;    // azimuths in b are those in a plus this
  double motion_rad = 0;  // azimuth in a of the direction to b
  // The least cost of each turn (columns of them), and of each direction with the best turn: means
  // over the columns, 0 (the same, if all are rich in edges) to 1 (uncorrelated) and beyond.
  std::vector<double> turn_costs;
  std::vector<double> motion_costs;
};

// Min-warping (Moeller, Krzykawski and Gerstmayr 2010) on the images of two signatures: for each
// turn and direction of motion, each column of a is matched to the best of the columns of b that
// the hypothesis allows it to move to, with the vertical scale that belongs to the shift: a
// landmark at angle x from the direction of motion comes to x' between x and pi, and its distance
// shrinks by sin(x') / sin(x). Each column of b is matched to a in the same way, and the cost of
// the hypothesis is the mean of both: so what only one of the two sees can't be matched cheaply.
// Columns are compared by the correlation of their gradients, up and around, softened so that
// bright windows don't outweigh the rest: brightness and contrast hardly matter. `band` is what the
// rows span. Both signatures must have the same rows (CheckFailure). Thread-safe.
Warping SearchWarping(const FourierSignature& a, const FourierSignature& b,
                      const ElevationBand& band, const WarpingOptions& options);

}  // namespace waystone
