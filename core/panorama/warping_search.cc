// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/warping_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/pose2.h"
#include "core/panorama/warping_kernels.h"

namespace waystone {
namespace {

constexpr double kMaxLevels = 100;      // of a byte, a unit of cost
constexpr double kMostPerColumn = 2.5;  // cost with its penalty: what a byte holds
constexpr double kMaxSum = 65535;       // of a hypothesis over the columns

// Change from row to row, upper to lower: edges without the brightness around them.
RowImage VerticalGradient(const RowImage& image) {
  const auto rows = image.rows();
  RowImage gradient = RowImage::Zero(rows, image.cols());
  if (rows > 2)
    gradient.middleRows(1, rows - 2) = image.bottomRows(rows - 2) - image.topRows(rows - 2);
  return gradient;
}

// Change from column to column, around the circle.
RowImage AzimuthGradient(const RowImage& image) {
  const auto columns = image.cols();
  RowImage gradient(image.rows(), columns);
  for (Eigen::Index j = 0; j < columns; ++j) {
    gradient.col(j) = image.col((j + 1) % columns) - image.col((j + columns - 1) % columns);
  }
  return gradient;
}

// g / (|g| + c), with c = softness times g's root mean square: strong edges count hardly more than
// clear ones.
RowImage SoftenEdges(const RowImage& gradient, double softness) {
  if (softness == 0) return gradient;
  constexpr float kNothing = 1e-9F;
  const double square = gradient.cast<double>().array().square().mean();
  const auto half = static_cast<float>(softness * std::sqrt(square)) + kNothing;
  return gradient.array() / (gradient.array().abs() + half);
}

// The image as it looks when everything is `scale` times nearer: elevation e becomes e' with
// tan(e') = scale tan(e). Rows outside the image are 0.
RowImage ScaleRows(const RowImage& image, const ElevationBand& band, double scale) {
  const auto rows = image.rows();
  const double step = (band.top_rad - band.bottom_rad) / static_cast<double>(rows);
  RowImage scaled = RowImage::Zero(rows, image.cols());
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double elevation = band.top_rad - (static_cast<double>(row) + 0.5) * step;
    const double from = (band.top_rad - std::atan(std::tan(elevation) / scale)) / step - 0.5;
    if (from < 0 || from > static_cast<double>(rows - 1)) continue;
    const auto upper = static_cast<Eigen::Index>(from);
    const auto part = static_cast<float>(from - static_cast<double>(upper));
    const Eigen::Index lower = std::min(upper + 1, rows - 1);
    scaled.row(row) = (1 - part) * image.row(upper) + part * image.row(lower);
  }
  return scaled;
}

// Normalises columns to length 1, weak ones to less; empty columns stay.
void NormaliseColumns(RowImage& image, double plain_share) {
  Eigen::RowVectorXf squares = Eigen::RowVectorXf::Zero(image.cols());
  for (Eigen::Index row = 0; row < image.rows(); ++row) squares += image.row(row).cwiseAbs2();
  const auto plain = static_cast<float>(plain_share) * squares.mean();
  // Eigen's own square roots of floats start from the processor's estimate, which differs between
  // processors.
  const Eigen::RowVectorXf factors = squares.unaryExpr([plain](float square) {
    constexpr float kNothing = std::numeric_limits<float>::epsilon();
    const float whole = square + plain;
    return whole > kNothing * kNothing ? 1 / std::sqrt(whole) : 1.0F;
  });
  for (Eigen::Index row = 0; row < image.rows(); ++row) {
    image.row(row) = image.row(row).cwiseProduct(factors);
  }
}

// The edges of an image that columns are compared by.
struct Edges {
  RowImage level;    // along the elevation
  RowImage upright;  // along the azimuth
};

Edges FindEdges(const RowImage& image, const WarpingOptions& options) {
  return {SoftenEdges(VerticalGradient(image), options.edge_softness),
          SoftenEdges(AzimuthGradient(image), options.edge_softness)};
}

// What columns are compared by at a scale: level edges above upright ones, of length 1 together,
// padded with empty columns to `filled`.
RowImage DescribeColumns(const Edges& edges, const ElevationBand& band, double scale, int filled,
                         const WarpingOptions& options) {
  const auto rows = edges.level.rows();
  RowImage level = ScaleRows(edges.level, band, scale);
  RowImage upright = ScaleRows(edges.upright, band, scale);
  NormaliseColumns(level, options.plain_share);
  NormaliseColumns(upright, options.plain_share);
  const auto share = static_cast<float>(options.upright_share);
  RowImage columns = RowImage::Zero(2 * rows, filled);
  columns.topLeftCorner(rows, level.cols()) = std::sqrt(1 - share) * level;
  columns.bottomLeftCorner(rows, level.cols()) = std::sqrt(share) * upright;
  return columns;
}

// One search: the costs of all pairs of columns at all scales, then all hypotheses, both ways.
// Costs are bytes, of which many fit a register: each is rounded, which averages out over the
// columns.
class Search {
 public:
  Search(const Edges& a, const Edges& b, const ElevationBand& band, const WarpingOptions& options)
      : options_(options),
        columns_(options.columns),
        turns_(FilledUp(columns_, kWarpingBytes)),
        levels_(static_cast<float>(
            std::min(kMaxLevels, std::floor(kMaxSum / (kMostPerColumn * columns_))))),
        step_rad_(2 * kPi / columns_) {
    const int middle = options_.scales / 2;
    const int filled = FilledUp(columns_, kWarpingFloats);
    std::vector<RowImage> of_a;  // from scale 1 on
    std::vector<RowImage> of_b;
    for (int s = middle; s < options_.scales; ++s) {
      of_a.push_back(DescribeColumns(a, band, ScaleOf(s), columns_, options_));
      of_b.push_back(DescribeColumns(b, band, ScaleOf(s), filled, options_));
    }
    for (int s = 0; s < options_.scales; ++s) {
      forth_.push_back(
          CompareColumns(of_a[std::max(0, s - middle)], of_b[std::max(0, middle - s)]));
    }
    for (int s = 0; s < options_.scales; ++s) {
      back_.push_back(Transpose(forth_[options_.scales - 1 - s]));
    }
  }

  // Mean cost of each hypothesis: rows are directions of motion, columns turns.
  RowImage Costs() const {
    const std::vector<uint16_t> forth = SumLeast(forth_);
    const std::vector<uint16_t> back = SumLeast(back_);
    RowImage costs(columns_, columns_);
    const float per_unit = 1 / (levels_ * static_cast<float>(2 * columns_));
    for (int motion = 0; motion < columns_; ++motion) {
      for (int turn = 0; turn < columns_; ++turn) {
        // Seen from b, a lies behind, and the turn is the other way.
        const int motion_back = (motion + turn + columns_ / 2) % columns_;
        const int turn_back = (columns_ - turn) % columns_;
        const int sum = forth[motion * turns_ + turn] + back[motion_back * turns_ + turn_back];
        costs(motion, turn) = per_unit * static_cast<float>(sum);
      }
    }
    return costs;
  }

 private:
  // Of one scale: columns x RowBytes().
  using CostTable = std::vector<uint8_t>;

  double ScaleOf(int s) const {
    return std::pow(options_.max_scale, 2.0 * s / (options_.scales - 1) - 1);
  }

  // The scale step of a ratio of distances, or -1 when it is out of range by more than half a step.
  int ScaleStepOf(double ratio) const {
    const double exponent = std::log(ratio) / std::log(options_.max_scale);  // -1 to 1
    const auto s = std::lround((exponent + 1) / 2 * (options_.scales - 1));
    return s < 0 || s >= options_.scales ? -1 : static_cast<int>(s);
  }

  // Half a circle before the columns and more than one and a half after them, so that neither shift
  // (at most a quarter) nor turn wraps, plus what the last register reads beyond.
  int Lead() const { return columns_ / 2; }
  int64_t RowBytes() const { return 3 * columns_ + kWarpingBytes; }

  CostTable CompareColumns(const RowImage& a, const RowImage& b) const {
    CostTable costs(columns_ * RowBytes());
    kernels_.multiply({static_cast<int>(a.rows()), columns_, a.data(), b.data(), levels_,
                       costs.data() + Lead(), RowBytes()});
    WrapRows(costs);
    return costs;
  }

  CostTable Transpose(const CostTable& costs) const {
    CostTable transposed(costs.size());
    for (int column = 0; column < columns_; ++column) {
      const uint8_t* from = costs.data() + column * RowBytes() + Lead();
      uint8_t* to = transposed.data() + Lead() + column;
      for (int other = 0; other < columns_; ++other) to[other * RowBytes()] = from[other];
    }
    WrapRows(transposed);
    return transposed;
  }

  void WrapRows(CostTable& costs) const {
    for (int column = 0; column < columns_; ++column) {
      uint8_t* row = costs.data() + column * RowBytes();
      for (int64_t k = Lead() + columns_; k < RowBytes(); ++k) row[k] = row[k - columns_];
      for (int64_t k = 0; k < Lead(); ++k) row[k] = row[k + columns_];
    }
  }

  // Of each direction of motion and turn, over the columns.
  std::vector<uint16_t> SumLeast(const std::vector<CostTable>& tables) const {
    std::vector<uint16_t> sums(static_cast<size_t>(columns_) * turns_, 0);
    for (int angle = 0; angle < columns_; ++angle) {
      const std::vector<ColumnStep> steps = FindSteps(tables, angle);
      kernels_.add_least(
          {steps.data(), static_cast<int>(steps.size()), columns_, RowBytes() + 1, angle, turns_},
          sums.data());
    }
    return sums;
  }

  // For landmarks `angle` columns clockwise of the direction of motion.
  std::vector<ColumnStep> FindSteps(const std::vector<CostTable>& tables, int angle) const {
    const double x = std::abs(WrappedAngle(angle * step_rad_));
    const int side = 2 * angle <= columns_ ? 1 : -1;
    const int middle = options_.scales / 2;
    std::vector<ColumnStep> steps;
    // Of column 0 and another, -Lead() to Lead(); those of the next of both are RowBytes() + 1 on.
    const auto add = [&](int scale, int column, int shift) {
      steps.push_back({tables[scale].data() + Lead() + column, PenaltyOf(shift)});
    };
    // Straight ahead and straight behind nothing moves sideways, and any distance goes.
    if (angle == 0) {
      for (int s = middle; s < options_.scales; ++s) add(s, 0, 0);
    } else if (2 * angle == columns_) {
      for (int s = 0; s <= middle; ++s) add(s, 0, 0);
    } else {
      const int reach = static_cast<int>(options_.max_shift_rad / step_rad_);
      for (int shift = 0; shift <= reach && x + shift * step_rad_ < kPi; ++shift) {
        const int s = ScaleStepOf(std::sin(x + shift * step_rad_) / std::sin(x));
        if (s >= 0) add(s, side * shift, shift);
      }
    }
    return steps;
  }

  uint8_t PenaltyOf(int shift) const {
    const double most = (kMostPerColumn - 2) * levels_ - 1;  // beside a cost of 2
    const double penalty = options_.shift_cost * shift * step_rad_ * levels_;
    return static_cast<uint8_t>(std::lround(std::min(penalty, most)));
  }

  const WarpingOptions& options_;
  int columns_;
  int turns_;  // filled up
  float levels_;
  double step_rad_;
  WarpingKernels kernels_ = FastestWarpingKernels();
  std::vector<CostTable> forth_;  // of each scale: columns of a by those of b
  std::vector<CostTable> back_;   // the other way round
};

// The offset of the minimum of a circle of values from its least sample, in -0.5 to 0.5: the vertex
// of the parabola through it and its neighbours.
double VertexOffset(const std::vector<double>& values, int least) {
  const int n = static_cast<int>(values.size());
  const double before = values[(least + n - 1) % n] - values[least];
  const double after = values[(least + 1) % n] - values[least];
  return before + after > 0 ? 0.5 * (before - after) / (before + after) : 0;
}

std::vector<double> ToVector(const Eigen::RowVectorXf& values) {
  return {values.begin(), values.end()};
}

}  // namespace

void WarpingOptions::Check() const {
  CheckFields("warping", *this);
  if (scales % 2 == 0) {
    throw MapError(ErrorCode::kBadOptions,
                   "scales is " + std::to_string(scales) + "; it must be odd");
  }
  if (columns % 2 != 0) {
    throw MapError(ErrorCode::kBadOptions,
                   "columns is " + std::to_string(columns) + "; it must be even");
  }
}

Warping SearchWarping(const FourierSignature& a, const FourierSignature& b,
                      const ElevationBand& band, const WarpingOptions& options) {
  options.Check();
  WS_CHECK(a.magnitudes.rows() == b.magnitudes.rows(), "signatures of different rows");
  const int frequencies =
      std::min({options.frequencies, CommonFrequencies(a), CommonFrequencies(b)});
  const Search search(FindEdges(Rebuild(a, frequencies, options.columns), options),
                      FindEdges(Rebuild(b, frequencies, options.columns), options), band, options);
  const RowImage costs = search.Costs();
  Eigen::Index motion = 0;
  Eigen::Index turn = 0;
  Warping warping;
  costs.minCoeff(&motion, &turn);
  warping.turn_costs = ToVector(costs.colwise().minCoeff());
  warping.motion_costs = ToVector(costs.col(turn).transpose());
  const double step_rad = 2 * kPi / options.columns;
  const std::vector<double> along_turn = ToVector(costs.row(motion));
  warping.turn_rad = (static_cast<double>(turn) + VertexOffset(along_turn, turn)) * step_rad;
  warping.motion_rad =
      (static_cast<double>(motion) + VertexOffset(warping.motion_costs, motion)) * step_rad;
  return warping;
}

}  // namespace waystone
