// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/options.h"
#include "core/manhattan/great_circles.h"

namespace waystone {

struct ManhattanOptions {
  int max_pairs = 300;
  int max_lines = 600;
  double line_sigma_rad = 0.003;
  double axis_sigma_rad = 0.008;
  double max_sigmas = 3.0;
  double vote_bin_rad = 0.0175;
  int refined_frames = 8;
  int max_steps = 12;
  uint64_t seed = 1;
  int min_second_lines = 4;
  double min_support = 0.25;
  double max_sigma_rad = 0.02;
  double max_rival = 0.9;
  double rival_angle_rad = 0.09;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_pairs", &ManhattanOptions::max_pairs, Closed(10, 100'000), "",
                    "Number of pairs of lines whose common direction is tried. If there are more, "
                    "pairs are drawn with a probability that depends on their lengths. More pairs "
                    "find weaker frames; time grows linearly."},
        OptionField{"max_lines", &ManhattanOptions::max_lines, Closed(10, 10'000), "",
                    "Maximum number of lines used, longest first; bounds the running time."},
        OptionField{"line_sigma_rad", &ManhattanOptions::line_sigma_rad, Closed(1e-4, 0.1), "rad",
                    "Standard deviation of the angle between a line of the building and its axis, "
                    "including calibration errors. Higher values tolerate inaccurate walls and "
                    "poor calibration, but accept more lines that belong to no axis."},
        OptionField{"axis_sigma_rad", &ManhattanOptions::axis_sigma_rad, Closed(0, 0.1), "rad",
                    "Standard deviation of an axis as a whole, shared by all its lines: "
                    "calibration, distortion, and walls that are not quite perpendicular. Higher "
                    "values weight the axes more equally and report a larger covariance."},
        OptionField{"max_sigmas", &ManhattanOptions::max_sigmas, Closed(1, 10), "",
                    "Maximum deviation of a line from its axis, in standard deviations. Also the "
                    "scale of the final refinement's robust kernel."},
        OptionField{"vote_bin_rad", &ManhattanOptions::vote_bin_rad, Closed(0.001, 0.1), "rad",
                    "Width of the voting bins for directions perpendicular to the first one."},
        OptionField{"refined_frames", &ManhattanOptions::refined_frames, Closed(1, 100), "",
                    "Number of candidate frames, those with the most votes, that are refined."},
        OptionField{"max_steps", &ManhattanOptions::max_steps, Closed(1, 100), "",
                    "Maximum number of refinement steps per frame."},
        OptionField{"seed", &ManhattanOptions::seed, AnyValue(), "",
                    "Random seed of the drawn pairs."},
        OptionField{"min_second_lines", &ManhattanOptions::min_second_lines, Closed(1, 100), "",
                    "Minimum number of lines of the second-best axis of a reliable frame, since a "
                    "frame is determined by two directions."},
        OptionField{"min_support", &ManhattanOptions::min_support, Closed(0, 1), "",
                    "Minimum share of the lines' total length that the axes of a reliable frame "
                    "must explain."},
        OptionField{"max_sigma_rad", &ManhattanOptions::max_sigma_rad, Closed(1e-4, 1), "rad",
                    "Maximum standard deviation of a reliable frame's rotation about its "
                    "worst-known direction."},
        OptionField{"max_rival", &ManhattanOptions::max_rival, Closed(0, 1), "",
                    "Maximum support of a reliable frame's rival (another frame, rotated by more "
                    "than rival_angle_rad), as a share of its own."},
        OptionField{"rival_angle_rad", &ManhattanOptions::rival_angle_rad, Closed(0.01, 0.7), "rad",
                    "Minimum rotation between a frame and its rival."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Why a frame isn't reliable.
enum class FrameError {
  kNone,
  kFewLines,       // hardly a line: fog, darkness, bare walls
  kOneDirection,   // the lines show one direction only
  kLittleSupport,  // most lines belong to no axis: not a Manhattan place
  kRival,          // another frame explains the lines nearly as well
  kUncertain,      // the lines don't determine the rotation well enough
};

// "none", "few_lines", "one_direction", "little_support", "rival_frame", "uncertain"; and a
// sentence for people.
std::string_view NameOf(FrameError error);
std::string_view SentenceOf(FrameError error);

// The rotation between a rig and the three orthogonal directions of a building. Which axis is
// which, and their signs, are arbitrary (24 rotations describe one frame): see NearestOfCube.
struct ManhattanFrame {
  // x_rig = rig_from_axes x_axes: columns are the vanishing points v_i = R e_i (sec. II-A).
  Eigen::Matrix3d rig_from_axes = Eigen::Matrix3d::Identity();
  // Of the rotation vector w, rig's frame, rad^2: R_true = exp(w) R. The lines' errors are taken
  // to be independent of each other, those of its axes as the options have them. The identity where
  // nothing is known.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::array<int, 3> lines{};       // that support each axis
  std::array<double, 3> support{};  // their share of the length of all lines
  double rival = 0;                 // support of the best other frame over this one's
  std::vector<int> axis_of_line;    // per line: 0, 1, 2, or -1 for none
  FrameError error = FrameError::kFewLines;

  bool reliable() const { return error == FrameError::kNone; }
  double sigma_rad() const;  // about the worst-known direction
};

// Finds the frame that explains most of the lines. As in sec. II-A, putative vanishing points
// v_m = l_i x l_j vote for a first direction; each is completed to a frame by voting for the
// direction across it, the third is their cross product, and frames compete by the support of all
// three axes. The best are refined as rotations by robust least squares on l^T v, where a line's
// error has the variance that its end points give it. No direction counts as upright. Always gives
// its best frame; `error` says whether to believe it. Deterministic; thread-safe.
ManhattanFrame FindManhattanFrame(std::span<const GreatCircle> lines,
                                  const ManhattanOptions& options = {});

// The prediction refined on the lines; other frames that explain them as well don't count as
// rivals, since the prediction has already chosen. The caller checks how far the result lies from
// the prediction. Deterministic; thread-safe.
ManhattanFrame FindManhattanFrameNear(std::span<const GreatCircle> lines,
                                      const Eigen::Matrix3d& rig_from_axes,
                                      const ManhattanOptions& options = {});

// The same frame with its axes numbered and signed so that they are nearest to `previous`
// (rig_from_axes of the frame before): how axes are followed through a sequence. See
// NearestOfCube.
ManhattanFrame Renumbered(ManhattanFrame frame, const Eigen::Matrix3d& previous);

}  // namespace waystone
