// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/manhattan/great_circles.h"

namespace waystone {

struct ManhattanOptions {
  // Pairs of lines whose common direction is tried; all pairs where there are fewer, else pairs
  // drawn by the lines' lengths, 10 to 100,000. More find weaker frames and cost time in
  // proportion.
  int max_pairs = 300;
  // Lines that are looked at, the longest ones, 10 to 10,000. Bounds the time.
  int max_lines = 600;
  // Standard sigma of the angle between a line of the building and its axis, plus what the
  // calibration leaves, 1e-4 to 0.1. Higher puts up with crooked buildings and poor calibration and
  // takes in more lines that belong to no axis. rad
  double line_sigma_rad = 0.003;
  // Standard sigma of an axis as a whole, shared by all its lines: calibration, distortion, and
  // directions of a building that aren't quite perpendicular, 0 to 0.1. Higher weighs the axes more
  // alike and states a larger covariance. rad
  double axis_sigma_rad = 0.008;
  // How many standard deviations a line of an axis may be off it, 1 to 10. Also the scale of the
  // final refinement's robust kernel.
  double max_sigmas = 3.0;
  // Width of the bins in which directions across the first one are counted, 0.001 to 0.1. rad
  double vote_bin_rad = 0.0175;
  // Best frames of the voting that are refined, 1 to 100.
  int refined_frames = 8;
  // Refinement steps a frame, 1 to 100.
  int max_steps = 12;
  // Seed of the pairs.
  uint64_t seed = 1;

  // What a frame needs to be called reliable.
  // Lines of its second-best axis: a frame needs two directions, 1 to 100.
  int min_second_lines = 4;
  // Share of the lines' length that its axes explain, 0 to 1.
  double min_support = 0.25;
  // Largest standard deviation of the rotation about its worst-known direction, 1e-4 to 1. rad
  double max_sigma_rad = 0.02;
  // Another frame, turned by more than `rival_angle_rad` (0.01 to 0.7), may reach this share of its
  // support at most, 0 to 1.
  double max_rival = 0.9;
  double rival_angle_rad = 0.09;

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
  // x_head = rig_from_axes x_axes: columns are the vanishing points v_i = R e_i (sec. II-A).
  Eigen::Matrix3d rig_from_axes = Eigen::Matrix3d::Identity();
  // Of the rotation vector w, rig's frame, rad^2: R_true = exp(w) R. The lines' errors are taken
  // to be independent of each other, those of its axes as the options have them. The identity where
  // nothing is known.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::array<int, 3> lines{};       // that support each axis
  std::array<double, 3> support{};  // their share of the length of all lines
  double rival = 0;                 // support of the best other frame over this one's
  std::vector<int> axis_of_line;    // a line: 0, 1, 2, or -1 for none
  FrameError error = FrameError::kFewLines;

  bool reliable() const { return error == FrameError::kNone; }
  double sigma_rad() const;  // about the worst-known direction
};

// Finds the frame that explains most of the lines. As in sec. II-A, putative vanishing points
// v_m = l_i x l_j vote for a first direction; each is completed to a frame by voting for the
// direction across it, the third is their cross product, and frames compete by the support of all
// three axes. The best are refined as rotations by robust least squares on l^T v, where a line's
// error has the variance that its end points give it. No direction counts as upright. Always gives
// its best frame; `trouble` says whether to believe it. Deterministic; thread-safe.
ManhattanFrame FindManhattanFrame(std::span<const GreatCircle> lines,
                                  const ManhattanOptions& options = {});

// The frame that a prediction becomes when it is refined on the lines; other frames that explain
// them as well don't count as rivals, the prediction has chosen already. The caller sees to how far
// the result may lie from the prediction. Deterministic; thread-safe.
ManhattanFrame FindManhattanFrameNear(std::span<const GreatCircle> lines,
                                      const Eigen::Matrix3d& rig_from_axes,
                                      const ManhattanOptions& options = {});

// The same frame with its axes numbered and signed so that they are nearest to `previous`
// (rig_from_axes of the frame before): how axes are followed through a sequence. See
// NearestOfCube.
ManhattanFrame Renumbered(ManhattanFrame frame, const Eigen::Matrix3d& previous);

}  // namespace waystone
