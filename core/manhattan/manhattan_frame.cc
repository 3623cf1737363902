// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/manhattan_frame.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "core/geometry/rotation.h"
#include "core/manhattan/cube_rotations.h"
#include "core/manhattan/line_model.h"

namespace waystone {
namespace {

// Sine of the angle between two normals below which their lines coincide and have no crossing.
constexpr double kSameLine = 0.02;
// The fewest lines for finding a frame: two directions take three.
constexpr int kLeastLines = 3;

struct ScoredFrame {
  Eigen::Matrix3d rig_from_axes;
  double support = 0;
};

// Draws lines with a probability in proportion to their weights.
class WeightedDraw {
 public:
  explicit WeightedDraw(std::span<const Line> lines) {
    double sum = 0;
    for (const Line& line : lines) sums_.push_back(sum += line.weight);
  }
  int Draw(Random& random) const {
    const double at = random.Uniform() * sums_.back();
    const auto found = std::ranges::upper_bound(sums_, at);
    return static_cast<int>(std::min<size_t>(found - sums_.begin(), sums_.size() - 1));
  }

 private:
  std::vector<double> sums_;
};

// Putative vanishing points v_m = l_i x l_j: of all pairs, or of drawn ones.
std::vector<Eigen::Vector3d> PutativePoints(std::span<const Line> lines,
                                            const ManhattanOptions& options) {
  std::vector<Eigen::Vector3d> points;
  const auto add = [&](int i, int j) {
    const Eigen::Vector3d cross = lines[i].normal.cross(lines[j].normal);
    if (cross.norm() > kSameLine) points.push_back(cross.normalized());
  };
  const int n = static_cast<int>(lines.size());
  if (static_cast<int64_t>(n) * (n - 1) / 2 <= options.max_pairs) {
    for (int i = 0; i < n; ++i) {
      for (int j = i + 1; j < n; ++j) add(i, j);
    }
    return points;
  }
  const WeightedDraw draw(lines);
  Random random(options.seed);
  for (int pair = 0; pair < options.max_pairs; ++pair) {
    const int i = draw.Draw(random);
    const int j = draw.Draw(random);
    if (i != j) add(i, j);
  }
  return points;
}

// The rotation about a first direction that most lines vote for. A line l meets the circle
// perpendicular to the direction at v x l, which may be the second or the third axis: angles count
// modulo a quarter turn.
Eigen::Matrix3d CompleteFrame(std::span<const Line> lines, const Eigen::Vector3d& first,
                              const ManhattanOptions& options) {
  const double quarter = 0.5 * std::numbers::pi;
  const int bins = std::max(4, static_cast<int>(std::ceil(quarter / options.vote_bin_rad)));
  std::vector<double> votes(bins, 0.0);
  std::vector<double> offsets(bins, 0.0);  // votes times their place within the bin
  const Eigen::Vector3d x = first.unitOrthogonal();
  const Eigen::Vector3d y = first.cross(x);
  for (const Line& line : lines) {
    const double on_x = line.normal.dot(x);
    const double on_y = line.normal.dot(y);
    // The nearer the normal is to the first direction, the less certain is the crossing.
    const double say = line.weight * (on_x * on_x + on_y * on_y);
    double angle = std::atan2(on_y, on_x);  // v x l is a quarter turn on: the same modulo that
    angle -= quarter * std::floor(angle / quarter);
    const double place = angle / quarter * bins;
    const int bin = std::min(bins - 1, static_cast<int>(place));
    votes[bin] += say;
    offsets[bin] += say * (place - bin);
  }
  const auto around = [&](const std::vector<double>& v, int bin) {
    return v[(bin + bins - 1) % bins] + v[bin] + v[(bin + 1) % bins];
  };
  int best = 0;
  for (int bin = 1; bin < bins; ++bin) {
    if (around(votes, bin) > around(votes, best)) best = bin;
  }
  const double sum = around(votes, best);
  const double shift = votes[(best + 1) % bins] - votes[(best + bins - 1) % bins];
  const double place = sum > 0 ? best + (around(offsets, best) + shift) / sum : best;
  const double angle = place / bins * quarter;
  Eigen::Matrix3d frame;
  frame.col(0) = first;
  frame.col(1) = std::cos(angle) * x + std::sin(angle) * y;
  frame.col(2) = first.cross(frame.col(1));
  return frame;
}

void SortBySupport(std::vector<ScoredFrame>& frames) {
  std::ranges::stable_sort(frames, std::greater<>(), &ScoredFrame::support);
}

// Frames by their support, the best first, each more than `apart_rad` from all better ones.
std::vector<ScoredFrame> Distinct(std::vector<ScoredFrame> frames, double apart_rad, int most) {
  SortBySupport(frames);
  std::vector<ScoredFrame> kept;
  for (const ScoredFrame& frame : frames) {
    if (static_cast<int>(kept.size()) == most) break;
    const bool near = std::ranges::any_of(kept, [&](const ScoredFrame& better) {
      return CubeAngle(better.rig_from_axes, frame.rig_from_axes) < apart_rad;
    });
    if (!near) kept.push_back(frame);
  }
  return kept;
}

FrameError JudgeFrame(const ManhattanFrame& frame, const ManhattanOptions& options) {
  std::array<int, 3> counts = frame.lines;
  std::ranges::sort(counts, std::greater<>());
  if (counts[0] < options.min_second_lines) return FrameError::kFewLines;
  if (counts[1] < options.min_second_lines) return FrameError::kOneDirection;
  const double support = frame.support[0] + frame.support[1] + frame.support[2];
  if (support < options.min_support) return FrameError::kLittleSupport;
  if (frame.rival > options.max_rival) return FrameError::kRival;
  if (frame.sigma_rad() > options.max_sigma_rad) return FrameError::kUncertain;
  return FrameError::kNone;
}

ManhattanFrame Describe(std::span<const Line> lines, size_t all_lines,
                        const RefinedRotation& refined, const ManhattanOptions& options) {
  ManhattanFrame frame;
  frame.rig_from_axes = refined.rig_from_axes;
  frame.covariance = refined.covariance;
  frame.axis_of_line.assign(all_lines, -1);
  for (const Line& line : lines) {
    const int axis = ComputeSupport(line, refined.rig_from_axes, options).axis;
    if (axis < 0) continue;
    frame.axis_of_line[line.index] = axis;
    ++frame.lines[axis];
    frame.support[axis] += line.weight;
  }
  return frame;
}

}  // namespace

double ManhattanFrame::sigma_rad() const { return WorstAxisSigma(covariance); }

ManhattanFrame FindManhattanFrame(std::span<const GreatCircle> circles,
                                  const ManhattanOptions& options) {
  options.Check();
  const std::vector<Line> lines = SelectLines(circles, options.max_lines);
  ManhattanFrame none;
  none.axis_of_line.assign(circles.size(), -1);
  if (static_cast<int>(lines.size()) < kLeastLines) return none;
  std::vector<ScoredFrame> voted;
  for (const Eigen::Vector3d& point : PutativePoints(lines, options)) {
    const Eigen::Matrix3d frame = CompleteFrame(lines, point, options);
    voted.push_back({frame, TotalSupport(lines, frame, options)});
  }
  if (voted.empty()) return none;
  std::vector<ScoredFrame> refined;
  for (const ScoredFrame& start :
       Distinct(std::move(voted), 0.5 * options.rival_angle_rad, options.refined_frames)) {
    const RefinedRotation better = RefineRotation(lines, start.rig_from_axes, options);
    refined.push_back({better.rig_from_axes, TotalSupport(lines, better.rig_from_axes, options)});
  }
  const std::vector<ScoredFrame> rivals = Distinct(std::move(refined), options.rival_angle_rad, 2);
  ManhattanFrame frame = Describe(lines, circles.size(),
                                  RefineRotation(lines, rivals[0].rig_from_axes, options), options);
  if (rivals.size() > 1 && rivals[0].support > 0) {
    frame.rival = rivals[1].support / rivals[0].support;
  }
  frame.error = JudgeFrame(frame, options);
  return frame;
}

ManhattanFrame FindManhattanFrameNear(std::span<const GreatCircle> circles,
                                      const Eigen::Matrix3d& rig_from_axes,
                                      const ManhattanOptions& options) {
  options.Check();
  const std::vector<Line> lines = SelectLines(circles, options.max_lines);
  ManhattanFrame frame;
  frame.rig_from_axes = rig_from_axes;
  frame.axis_of_line.assign(circles.size(), -1);
  if (static_cast<int>(lines.size()) < kLeastLines) return frame;
  frame = Describe(lines, circles.size(), RefineRotation(lines, rig_from_axes, options), options);
  frame.error = JudgeFrame(frame, options);
  return frame;
}

ManhattanFrame Renumbered(ManhattanFrame frame, const Eigen::Matrix3d& previous) {
  const Eigen::Matrix3d nearest = NearestOfCube(frame.rig_from_axes, previous);
  // Column i of the nearest is plus or minus column from[i] of what it was.
  const Eigen::Matrix3d cube = frame.rig_from_axes.transpose() * nearest;
  std::array<int, 3> to{};
  const ManhattanFrame before = frame;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Index from = 0;
    cube.col(axis).cwiseAbs().maxCoeff(&from);
    to[from] = axis;
    frame.lines[axis] = before.lines[from];
    frame.support[axis] = before.support[from];
  }
  for (int& axis : frame.axis_of_line) {
    if (axis >= 0) axis = to[axis];
  }
  frame.rig_from_axes = nearest;
  return frame;
}

void ManhattanOptions::Check() const { CheckFields("manhattan", *this); }

std::string_view NameOf(FrameError error) {
  switch (error) {
    case FrameError::kNone:
      return "none";
    case FrameError::kFewLines:
      return "few_lines";
    case FrameError::kOneDirection:
      return "one_direction";
    case FrameError::kLittleSupport:
      return "little_support";
    case FrameError::kRival:
      return "rival_frame";
    default:
      return "uncertain";
  }
}

std::string_view SentenceOf(FrameError error) {
  switch (error) {
    case FrameError::kNone:
      return "reliable";
    case FrameError::kFewLines:
      return "too few line segments";
    case FrameError::kOneDirection:
      return "the lines show a single direction";
    case FrameError::kLittleSupport:
      return "most lines fit no common frame";
    case FrameError::kRival:
      return "another frame fits almost as well";
    default:
      return "the rotation is poorly determined";
  }
}

}  // namespace waystone
