// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/warping_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/angle.h"
#include "core/base/check.h"
#include "core/base/error.h"
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

// The image as it looks when everything is `scale` times nearer: what was at elevation e comes to
// tan(e') = scale tan(e). Columns have mean 0 and length 1 (0 where there is nothing), and are
// filled up with empty ones to `filled`.
RowImage ScaledColumns(const RowImage& image, const ElevationBand& band, double scale, int filled) {
  const auto rows = image.rows();
  const double step = (band.top_rad - band.bottom_rad) / static_cast<double>(rows);
  RowImage scaled = RowImage::Zero(rows, filled);
  auto used = scaled.leftCols(image.cols());
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double elevation = band.top_rad - (static_cast<double>(row) + 0.5) * step;
    const double from = (band.top_rad - std::atan(std::tan(elevation) / scale)) / step - 0.5;
    if (from < 0 || from > static_cast<double>(rows - 1)) continue;
    const auto upper = static_cast<Eigen::Index>(from);
    const auto part = static_cast<float>(from - static_cast<double>(upper));
    const Eigen::Index lower = std::min(upper + 1, rows - 1);
    used.row(row) = (1 - part) * image.row(upper) + part * image.row(lower);
  }
  const Eigen::RowVectorXf means = used.colwise().mean();
  used.rowwise() -= means;
  Eigen::RowVectorXf squares = Eigen::RowVectorXf::Zero(used.cols());
  for (Eigen::Index row = 0; row < rows; ++row) squares += used.row(row).cwiseAbs2();
  // Eigen's own roots of floats begin with what the processor guesses, and processors differ.
  const Eigen::RowVectorXf factors = squares.unaryExpr([](float square) {
    constexpr float kNothing = std::numeric_limits<float>::epsilon();
    return square > kNothing * kNothing ? 1 / std::sqrt(square) : 1.0F;
  });
  for (Eigen::Index row = 0; row < rows; ++row) {
    used.row(row) = used.row(row).cwiseProduct(factors);
  }
  return scaled;
}

// One search: the costs of all pairs of columns at all scales, then all hypotheses. Costs are
// bytes, of which many fit a register: each is rounded, and of a mean over the columns nothing is
// left of that.
class Search {
 public:
  Search(const RowImage& a, const RowImage& b, const ElevationBand& band,
         const WarpingOptions& options)
      : options_(options),
        columns_(options.columns),
        turns_(FilledUp(columns_, kWarpingBytes)),
        levels_(static_cast<float>(
            std::min(kMaxLevels, std::floor(kMaxSum / (kMostPerColumn * options.columns))))),
        step_rad_(2 * kPi / columns_) {
    const int middle = options_.scales / 2;
    std::vector<RowImage> of_a;  // from scale 1 on
    std::vector<RowImage> of_b;
    for (int s = middle; s < options_.scales; ++s) {
      of_a.push_back(ScaledColumns(a, band, ScaleOf(s), columns_));
      of_b.push_back(ScaledColumns(b, band, ScaleOf(s), FilledUp(columns_, kWarpingFloats)));
    }
    for (int s = 0; s < options_.scales; ++s) {
      costs_.push_back(
          CompareColumns(of_a[std::max(0, s - middle)], of_b[std::max(0, middle - s)]));
    }
  }

  // Mean cost of each hypothesis: rows are directions of motion, columns turns.
  RowImage Costs() const {
    std::vector<uint16_t> sums(static_cast<size_t>(columns_) * turns_, 0);
    for (int angle = 0; angle < columns_; ++angle) {
      const std::vector<ColumnStep> steps = FindSteps(angle);
      kernels_.add_least(
          {steps.data(), static_cast<int>(steps.size()), columns_, RowBytes() + 1, angle, turns_},
          sums.data());
    }
    RowImage costs(columns_, columns_);
    const float per_unit = 1 / (levels_ * static_cast<float>(columns_));
    for (int motion = 0; motion < columns_; ++motion) {
      for (int turn = 0; turn < columns_; ++turn) {
        costs(motion, turn) = per_unit * static_cast<float>(sums[motion * turns_ + turn]);
      }
    }
    return costs;
  }

  // Mean cost of each turn without motion.
  Eigen::RowVectorXf StillCosts() const {
    const uint8_t* same_scale = CostsFrom(options_.scales / 2, 0);
    Eigen::RowVectorXf total = Eigen::RowVectorXf::Zero(columns_);
    for (int column = 0; column < columns_; ++column) {
      const uint8_t* row = same_scale + column * (RowBytes() + 1);
      for (int turn = 0; turn < columns_; ++turn) total[turn] += row[turn];
    }
    return total / (levels_ * static_cast<float>(columns_));
  }

 private:
  double ScaleOf(int s) const {
    return std::pow(options_.max_scale, 2.0 * s / (options_.scales - 1) - 1);
  }

  // The step of a ratio of distances, or -1 when it is out of reach by more than half a step.
  int ScaleStepOf(double ratio) const {
    const double exponent = std::log(ratio) / std::log(options_.max_scale);  // -1 to 1
    const auto s = std::lround((exponent + 1) / 2 * (options_.scales - 1));
    return s < 0 || s >= options_.scales ? -1 : static_cast<int>(s);
  }

  // Half a circle before the columns of b and more than one and a half after them, so that neither
  // shift (a quarter at most) nor turn wraps, and what the last register reads beyond.
  int Lead() const { return columns_ / 2; }
  int64_t RowBytes() const { return 3 * columns_ + kWarpingBytes; }

  // Of column 0 of a and a column of b, -Lead() to Lead(); of the next of both RowBytes() + 1 on.
  const uint8_t* CostsFrom(int scale, int column_of_b) const {
    return costs_[scale].data() + Lead() + column_of_b;
  }

  std::vector<uint8_t> CompareColumns(const RowImage& a, const RowImage& b) const {
    std::vector<uint8_t> costs(columns_ * RowBytes());
    kernels_.multiply({static_cast<int>(a.rows()), columns_, a.data(), b.data(), levels_,
                       costs.data() + Lead(), RowBytes()});
    for (int column = 0; column < columns_; ++column) {
      uint8_t* row = costs.data() + column * RowBytes();
      for (int64_t k = Lead() + columns_; k < RowBytes(); ++k) row[k] = row[k - columns_];
      for (int64_t k = 0; k < Lead(); ++k) row[k] = row[k + columns_];
    }
    return costs;
  }

  // For landmarks `angle` columns clockwise of the direction of motion.
  std::vector<ColumnStep> FindSteps(int angle) const {
    const double x = std::abs(std::remainder(angle * step_rad_, 2 * kPi));
    const int side = 2 * angle <= columns_ ? 1 : -1;
    const int middle = options_.scales / 2;
    std::vector<ColumnStep> steps;
    // Straight ahead and straight behind nothing moves sideways, and any distance goes.
    if (angle == 0) {
      for (int s = middle; s < options_.scales; ++s) steps.push_back({CostsFrom(s, 0), 0});
    } else if (2 * angle == columns_) {
      for (int s = 0; s <= middle; ++s) steps.push_back({CostsFrom(s, 0), 0});
    } else {
      const int reach = static_cast<int>(options_.max_shift_rad / step_rad_);
      for (int shift = 0; shift <= reach && x + shift * step_rad_ < kPi; ++shift) {
        const int s = ScaleStepOf(std::sin(x + shift * step_rad_) / std::sin(x));
        if (s >= 0) steps.push_back({CostsFrom(s, side * shift), PenaltyOf(shift)});
      }
    }
    return steps;
  }

  uint8_t PenaltyOf(int shift) const {
    const double most = (kMostPerColumn - 2) * levels_ - 1;  // beside a cost of 2
    return static_cast<uint8_t>(std::lround(std::min(options_.shift_cost * shift * levels_, most)));
  }

  const WarpingOptions& options_;
  int columns_;
  int turns_;  // filled up
  float levels_;
  double step_rad_;
  WarpingKernels kernels_ = FastestWarpingKernels();
  std::vector<std::vector<uint8_t>> costs_;  // of each scale: columns x RowBytes
};

// Where between its neighbours the least of a circle of values lies, in -0.5 to 0.5: the vertex of
// the parabola through the three.
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
                   "scales is " + std::to_string(scales) + "; give an odd number");
  }
}

Warping SearchWarping(const FourierSignature& a, const FourierSignature& b,
                      const ElevationBand& band, const WarpingOptions& options) {
  options.Check();
  WS_CHECK(a.magnitudes.rows() == b.magnitudes.rows(), "signatures of different rows");
  const int frequencies =
      std::min({options.frequencies, CommonFrequencies(a), CommonFrequencies(b)});
  const Search search(VerticalGradient(Rebuild(a, frequencies, options.columns)),
                      VerticalGradient(Rebuild(b, frequencies, options.columns)), band, options);
  const RowImage costs = search.Costs();
  Eigen::Index motion = 0;
  Eigen::Index turn = 0;
  Warping warping;
  warping.cost = costs.minCoeff(&motion, &turn);
  warping.still_cost = search.StillCosts().minCoeff();
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
