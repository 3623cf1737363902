// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/warping_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/option_range.h"

namespace waystone {
namespace {

constexpr double kPi = std::numbers::pi;

// Change from row to row, upper to lower: edges without the brightness around them.
RowImage VerticalGradient(const RowImage& image) {
  const auto rows = image.rows();
  RowImage gradient = RowImage::Zero(rows, image.cols());
  if (rows > 2)
    gradient.middleRows(1, rows - 2) = image.bottomRows(rows - 2) - image.topRows(rows - 2);
  return gradient;
}

// The image as it looks when everything is `scale` times nearer: what was at elevation e comes to
// tan(e') = scale tan(e). Columns have mean 0 and length 1 (0 where there is nothing).
RowImage ScaledColumns(const RowImage& image, const ElevationBand& band, double scale) {
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
  scaled.rowwise() -= scaled.colwise().mean();
  for (Eigen::Index j = 0; j < scaled.cols(); ++j) {
    const float length = scaled.col(j).norm();
    if (length > std::numeric_limits<float>::epsilon()) scaled.col(j) /= length;
  }
  return scaled;
}

// One search: the costs of all pairs of columns at all scales, then all hypotheses.
class Search {
 public:
  Search(const RowImage& a, const RowImage& b, const ElevationBand& band,
         const WarpingOptions& options)
      : options_(options), columns_(options.columns), step_rad_(2 * kPi / columns_) {
    for (int s = 0; s < options_.scales; ++s) {
      const double scale = ScaleOf(s);
      const RowImage columns_a = ScaledColumns(a, band, std::max(scale, 1.0));
      const RowImage columns_b = ScaledColumns(b, band, std::max(1 / scale, 1.0));
      RowImage cost(columns_, 2 * columns_);  // twice around, so that no turn wraps
      cost.leftCols(columns_).noalias() = -(columns_a.transpose() * columns_b);
      cost.leftCols(columns_).array() += 1;
      cost.rightCols(columns_) = cost.leftCols(columns_);
      costs_.push_back(std::move(cost));
    }
  }

  // Mean cost of each hypothesis: rows are directions of motion, columns turns.
  RowImage Costs() const {
    RowImage total = RowImage::Zero(columns_, columns_);
    for (int angle = 0; angle < columns_; ++angle) {
      const RowImage best = BestMatches(angle);
      for (int column = 0; column < columns_; ++column) {
        const int motion = (column - angle + columns_) % columns_;
        total.row(motion) += best.row(column);
      }
    }
    return total / static_cast<float>(columns_);
  }

  // Mean cost of each turn without motion.
  Eigen::RowVectorXf StillCosts() const {
    const RowImage& same_scale = costs_[options_.scales / 2];
    Eigen::RowVectorXf total = Eigen::RowVectorXf::Zero(columns_);
    for (int column = 0; column < columns_; ++column) {
      total += same_scale.row(column).segment(column, columns_);
    }
    return total / static_cast<float>(columns_);
  }

 private:
  double ScaleOf(int s) const {
    return std::pow(options_.max_scale, 2.0 * s / (options_.scales - 1) - 1);
  }

  // The step of a ratio of distances, or -1 when it is out of reach by more than half a step.
  int StepOf(double ratio) const {
    const double exponent = std::log(ratio) / std::log(options_.max_scale);  // -1 to 1
    const auto s = std::lround((exponent + 1) / 2 * (options_.scales - 1));
    return s < 0 || s >= options_.scales ? -1 : static_cast<int>(s);
  }

  // For landmarks `angle` columns clockwise of the direction of motion: the least cost of each
  // column of a (row) under each turn (column).
  RowImage BestMatches(int angle) const {
    RowImage best = RowImage::Constant(columns_, columns_, std::numeric_limits<float>::max());
    const double x = std::abs(std::remainder(angle * step_rad_, 2 * kPi));
    const int side = 2 * angle <= columns_ ? 1 : -1;
    // Straight ahead and straight behind nothing moves sideways, and any distance goes.
    if (angle == 0) {
      AddScales(options_.scales / 2, options_.scales - 1, 0, best);
    } else if (2 * angle == columns_) {
      AddScales(0, options_.scales / 2, 0, best);
    } else {
      const int reach = static_cast<int>(options_.max_shift_rad / step_rad_);
      for (int shift = 0; shift <= reach && x + shift * step_rad_ < kPi; ++shift) {
        const int s = StepOf(std::sin(x + shift * step_rad_) / std::sin(x));
        if (s >= 0) AddScales(s, s, side * shift, best);
      }
    }
    return best;
  }

  void AddScales(int first, int last, int shift, RowImage& best) const {
    const auto penalty = static_cast<float>(options_.shift_cost * std::abs(shift));
    for (int s = first; s <= last; ++s) {
      for (int column = 0; column < columns_; ++column) {
        const int to = (column + shift + columns_) % columns_;
        best.row(column) = best.row(column).cwiseMin(
            (costs_[s].row(column).segment(to, columns_).array() + penalty).matrix());
      }
    }
  }

  const WarpingOptions& options_;
  int columns_;
  double step_rad_;
  std::vector<RowImage> costs_;  // of each scale: columns x 2 columns
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
  CheckRange("columns", columns, 24, 360);
  CheckRange("frequencies", frequencies, 4, 4096);
  CheckRange("max_shift_rad", max_shift_rad, 0.05, 1.5);
  CheckRange("max_scale", max_scale, 1.1, 5);
  CheckRange("scales", scales, 3, 41);
  CheckRange("shift_cost", shift_cost, 0, 0.5);
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
