// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/small_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/option_range.h"

namespace waystone {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kColumnsPerFrequency = 3;  // samples of the shortest wave, for linear interpolation
constexpr double kDeviationOfMedian = 1.4826;  // normal deviation over median absolute deviation

// Turn, motion to the front and to the right, tilt (front, right), gain less 1, the waves of the
// landmarks' nearness.
constexpr int kGain = 5;
constexpr int kNearness = 6;
constexpr int kWaves = 4;
constexpr int kParameters = kNearness + kWaves;
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Information = Eigen::Matrix<double, kParameters, kParameters>;

// Grey value and its slopes along columns and rows (a pixel), at a position between pixels.
struct Sample {
  float value = 0;
  float along_columns = 0;
  float along_rows = 0;
};

// Bilinear; x wraps around, y must lie in [0, rows - 1).
Sample SampleAt(const RowImage& image, double x, double y) {
  const auto columns = static_cast<int>(image.cols());
  const double left = std::floor(x);
  const auto fx = static_cast<float>(x - left);
  const int x0 = ((static_cast<int>(left) % columns) + columns) % columns;
  const int x1 = x0 + 1 == columns ? 0 : x0 + 1;
  const int y0 = static_cast<int>(y);
  const auto fy = static_cast<float>(y - y0);
  const float a = image(y0, x0);
  const float b = image(y0, x1);
  const float c = image(y0 + 1, x0);
  const float d = image(y0 + 1, x1);
  const float upper = a + fx * (b - a);
  const float lower = c + fx * (d - c);
  return {upper + fy * (lower - upper), (1 - fy) * (b - a) + fy * (d - c), lower - upper};
}

double MedianOf(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// One stage: two images of so many frequencies; b is turned already by what is known of the turn.
class Stage {
 public:
  Stage(RowImage a, RowImage b, const ElevationBand& band, const SmallMotionOptions& options)
      : a_(std::move(a)),
        b_(std::move(b)),
        options_(options),
        row_step_rad_((band.top_rad - band.bottom_rad) / static_cast<double>(a_.rows())),
        column_step_rad_(2 * kPi / static_cast<double>(a_.cols())) {
    for (Eigen::Index j = 0; j < a_.cols(); ++j) {
      const double azimuth = static_cast<double>(j) * column_step_rad_;
      cosines_.push_back(std::cos(azimuth));
      sines_.push_back(std::sin(azimuth));
      waves_.emplace_back(std::cos(azimuth), std::sin(azimuth), std::cos(2 * azimuth),
                          std::sin(2 * azimuth));
    }
    for (Eigen::Index i = 0; i < a_.rows(); ++i) {
      const double elevation = band.top_rad - (static_cast<double>(i) + 0.5) * row_step_rad_;
      lifts_.push_back(std::sin(elevation) * std::cos(elevation));
    }
  }

  // The residuals, and their slopes by the parameters, at `p`.
  void Linearise(const Parameters& p) {
    residuals_.clear();
    slopes_.clear();
    for (Eigen::Index i = 0; i < a_.rows(); ++i) {
      for (Eigen::Index j = 0; j < a_.cols(); ++j) AddPixel(p, i, j);
    }
    WS_CHECK(!residuals_.empty(), "no overlap of two signatures");
    std::vector<float> magnitudes(residuals_.size());
    std::ranges::transform(residuals_, magnitudes.begin(), [](float r) { return std::abs(r); });
    deviation_ = std::max(kDeviationOfMedian * MedianOf(std::move(magnitudes)), 1e-9);
  }

  // One Gauss-Newton step; leaves the information (inverse covariance) of what it was taken from.
  Parameters Step(const Parameters& p) {
    information_.setZero();
    Parameters gradient = Parameters::Zero();
    for (size_t k = 0; k < residuals_.size(); ++k) {
      const double weight = WeightOf(residuals_[k]);
      const Parameters slope = slopes_[k].cast<double>();
      information_.selfadjointView<Eigen::Lower>().rankUpdate(slope, weight);
      gradient += weight * residuals_[k] * slope;
    }
    information_ = information_.selfadjointView<Eigen::Lower>();
    // The waves' prior, in the units of the residuals.
    const double prior = deviation_ * deviation_ * options_.correlated_pixels /
                         (options_.nearness_deviation * options_.nearness_deviation);
    information_.diagonal().tail<kWaves>().array() += prior;
    gradient.tail<kWaves>() += prior * p.tail<kWaves>();
    // A band without texture in some direction leaves that direction where it is.
    information_.diagonal().array() += 1e-6 * information_.trace();
    return -information_.ldlt().solve(gradient);
  }

  Information Covariance() const {
    return information_.inverse() * (deviation_ * deviation_ * options_.correlated_pixels);
  }

  // How much of a is explained: 1 - weighted squares of residuals over those of a.
  double Correlation() const {
    double residual = 0;
    double whole = 0;
    for (size_t k = 0; k < residuals_.size(); ++k) {
      const double grey = slopes_[k][kGain];
      residual += WeightOf(residuals_[k]) * residuals_[k] * residuals_[k];
      whole += WeightOf(residuals_[k]) * grey * grey;
    }
    return whole > 0 ? 1 - residual / whole : 0;
  }

 private:
  double WeightOf(double residual) const {
    const double share = residual / (options_.cauchy_deviations * deviation_);
    return 1 / (1 + share * share);
  }

  void AddPixel(const Parameters& p, Eigen::Index i, Eigen::Index j) {
    const double c = cosines_[j];
    const double s = sines_[j];
    const double lift = lifts_[i];
    const Eigen::Vector4d& waves = waves_[j];
    const double near = 1 + waves.dot(p.tail<kWaves>());
    const double aside = p[1] * s - p[2] * c;  // what a landmark at nearness 1 moves by
    const double up = lift * (p[1] * c + p[2] * s);
    const double du = p[0] + near * aside;
    const double dv = near * up + p[3] * c + p[4] * s;
    const double y = static_cast<double>(i) - dv / row_step_rad_;
    if (y < 0 || y >= static_cast<double>(a_.rows() - 1)) return;
    const Sample b = SampleAt(b_, static_cast<double>(j) + du / column_step_rad_, y);
    const double u = b.along_columns / column_step_rad_;
    const double v = -b.along_rows / row_step_rad_;
    Parameters slope;
    slope << u, near * (u * s + v * lift * c), near * (-u * c + v * lift * s), v * c, v * s,
        -a_(i, j), (u * aside + v * up) * waves;
    residuals_.push_back(static_cast<float>(b.value - (1 + p[kGain]) * a_(i, j)));
    slopes_.push_back(slope.cast<float>());
  }

  RowImage a_;
  RowImage b_;
  const SmallMotionOptions& options_;
  double row_step_rad_;
  double column_step_rad_;
  std::vector<double> cosines_;  // of each column's azimuth
  std::vector<double> sines_;
  std::vector<Eigen::Vector4d> waves_;
  std::vector<double> lifts_;  // sin e cos e of each row
  std::vector<float> residuals_;
  std::vector<Eigen::Matrix<float, kParameters, 1>> slopes_;
  double deviation_ = 0;
  Information information_ = Information::Zero();
};

// The image of the frequencies below `frequencies` without the rows' means, which don't turn.
RowImage Ripples(const FourierSignature& signature, int frequencies, double turn_rad) {
  RowImage image = Rebuild(signature, frequencies, kColumnsPerFrequency * frequencies, turn_rad);
  image.colwise() -= image.rowwise().mean();
  return image;
}

}  // namespace

void SmallMotionOptions::Check() const {
  CheckRange("coarse_frequencies", coarse_frequencies, 2, 64);
  CheckRange("steps", steps, 1, 50);
  CheckRange("cauchy_deviations", cauchy_deviations, 1, 10);
  CheckRange("nearness_deviation", nearness_deviation, 0.01, 10);
  CheckRange("correlated_pixels", correlated_pixels, 1, 1000);
}

SmallMotion RefineSmallMotion(const FourierSignature& a, const FourierSignature& b,
                              const ElevationBand& band, double turn_rad,
                              const SmallMotionOptions& options) {
  options.Check();
  WS_CHECK(a.magnitudes.rows() == b.magnitudes.rows() && a.magnitudes.rows() >= 2,
           "signatures of different rows, or of one");
  const int frequencies = std::min(CommonFrequencies(a), CommonFrequencies(b));
  Parameters p = Parameters::Zero();
  SmallMotion result;
  for (int stage = std::min(options.coarse_frequencies, frequencies);;
       stage = std::min(2 * stage, frequencies)) {
    // The turn is taken exactly from the phases; the rest is small.
    turn_rad += p[0];
    p[0] = 0;
    Stage images(Ripples(a, stage, 0), Ripples(b, stage, turn_rad), band, options);
    for (int step = 0; step < options.steps; ++step) {
      images.Linearise(p);
      p += images.Step(p);
    }
    if (stage < frequencies) continue;
    images.Linearise(p);
    images.Step(p);
    const Information covariance = images.Covariance();
    result.turn_deviation_rad = std::sqrt(covariance(0, 0));
    result.motion_covariance = covariance.block<2, 2>(1, 1);
    result.correlation = images.Correlation();
    break;
  }
  result.turn_rad = turn_rad + p[0];
  result.motion = p.segment<2>(1);
  result.tilt_rad = p.segment<2>(3);
  return result;
}

}  // namespace waystone
