// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/small_motion.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/linear_algebra.h"
#include "core/panorama/motion_kernels.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

constexpr int kColumnsPerFrequency = 3;    // samples of the shortest wave, for linear interpolation
constexpr double kSigmaOfMedian = 1.4826;  // normal sigma over median absolute deviation

// Turn, motion to the front and to the right, tilt (front, right), gain less 1, the waves of the
// landmarks' nearness.
constexpr int kGain = 5;
constexpr int kNearness = 6;
constexpr int kWaves = 4;
constexpr int kParameters = kNearness + kWaves;
static_assert(kParameters == kMotionParameters);
constexpr size_t kStepSamples = 250;    // about how many residuals a step's median is taken of
constexpr size_t kFinalSamples = 2000;  // and the final one, which scales the sigmas
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Information = Eigen::Matrix<double, kParameters, kParameters>;

// Pixels, block by block as the kernels want them.
using Pixels = std::vector<float>;

// Where each column of a comes from in b; for columns that pad the last block this is arbitrary.
struct ColumnMap {
  std::vector<int> left;  // column, and the next one around the circle
  std::vector<int> right;
  std::vector<float> part;  // of the way from left to right
  std::vector<float> lift;  // rows up, for a row's lift of 1
  std::vector<float> tilt;  // rows up
};

int BlocksOf(int columns) { return (columns + kMotionLanes - 1) / kMotionLanes; }

// The median of magnitudes, from a sample, which is accurate enough.
double MedianMagnitude(const Pixels& residuals, const Pixels& weights, size_t samples) {
  const size_t step = std::max<size_t>(1, residuals.size() / samples) | 1;  // odd: all columns
  std::vector<float> values;
  values.reserve(residuals.size() / step + 1);
  for (size_t k = 0; k < residuals.size(); k += step) {
    if (weights[k] > 0) values.push_back(std::abs(residuals[k]));
  }
  WS_CHECK(!values.empty(), "no overlap of two signatures");
  return Median(std::move(values));
}

// One stage: two images with the stage's frequencies; b is already turned by the current estimate.
class Stage {
 public:
  Stage(const RowImage& a, const RowImage& b, const ElevationBand& band,
        const SmallMotionOptions& options)
      : b_(b),
        options_(options),
        rows_(static_cast<int>(a.rows())),
        columns_(static_cast<int>(a.cols())),
        blocks_(BlocksOf(columns_)),
        rows_per_rad_(rows_ / (band.top_rad - band.bottom_rad)),
        columns_per_rad_(columns_ / (2 * kPi)) {
    for (int j = 0; j < blocks_ * kMotionLanes; ++j) {
      const double azimuth = j / columns_per_rad_;
      const double c = std::cos(azimuth);
      const double s = std::sin(azimuth);
      const double waves[kWaves] = {c, s, c * c - s * s, 2 * s * c};
      for (int wave = 0; wave < kWaves; ++wave) {
        waves_[wave].push_back(static_cast<float>(waves[wave]));
      }
      inside_.push_back(j < columns_ ? 1.0F : 0.0F);
    }
    for (int i = 0; i < rows_; ++i) {
      const double elevation = band.top_rad - (i + 0.5) / rows_per_rad_;
      lifts_.push_back(static_cast<float>(std::sin(elevation) * std::cos(elevation)));
    }
    for (Pixels* pixels : {&a_, &turned_, &slope_, &residual_, &u_, &v_, &weight_}) {
      pixels->resize(static_cast<size_t>(rows_) * blocks_ * kMotionLanes);
    }
    for (int j = 0; j < columns_; ++j) {
      for (int i = 0; i < rows_; ++i) a_[At(i, j)] = a(i, j);
    }
    moments_.resize(MomentsAt(blocks_));
    for (std::vector<float>* each : {&nearness_, &aside_, &along_}) {
      each->resize(static_cast<size_t>(blocks_) * kMotionLanes);
    }
  }

  // The normal equations at `p`.
  void Linearise(const Parameters& p, size_t median_samples) {
    Look(p, median_samples);
    std::vector<float> entries(static_cast<size_t>(kMotionEntries) * kMotionLanes, 0);
    for (int i = 0; i < blocks_; ++i) {
      kernels_.add(ColumnsOf(i), moments_.data() + MomentsAt(i), entries.data());
    }
    const float* entry = entries.data();
    const auto next = [&] {
      entry += kMotionLanes;
      return std::accumulate(entry - kMotionLanes, entry, 0.0);
    };
    for (int row = 0; row < kParameters; ++row) {
      for (int column = 0; column <= row; ++column) {
        information_(row, column) = information_(column, row) = next();
      }
    }
    for (int row = 0; row < kParameters; ++row) gradient_[row] = next();
  }

  // One Gauss-Newton step; leaves the information (inverse covariance) of what it was taken from.
  Parameters Step(const Parameters& p) {
    // The waves' prior, in the units of the residuals.
    const double prior = sigma_ * sigma_ * options_.correlated_pixels /
                         (options_.nearness_sigma * options_.nearness_sigma);
    information_.diagonal().tail<kWaves>().array() += prior;
    gradient_.tail<kWaves>() += prior * p.tail<kWaves>();
    // Keeps directions in which the band has no texture unchanged.
    information_.diagonal().array() += 1e-6 * information_.trace();
    return -SolveSymmetric(information_, gradient_);
  }

  Information Covariance() const {
    return InvertSymmetric(information_) * (sigma_ * sigma_ * options_.correlated_pixels);
  }

  // How much of a is explained: 1 - weighted squares of residuals over those of a.
  double Correlation() const {
    double whole = 0;
    double residual = 0;
    for (int j = 0; j < columns_; ++j) {
      whole += MomentOf(kAA, j);
      residual += MomentOf(kRR, j);
    }
    return whole > 0 ? 1 - residual / whole : 0;
  }

 private:
  // Of a pixel in the kernels' order.
  size_t At(int row, int column) const {
    const int block = column / kMotionLanes;
    return static_cast<size_t>(block * rows_ + row) * kMotionLanes + column % kMotionLanes;
  }

  float MomentOf(Moment moment, int column) const {
    const int block = column / kMotionLanes;
    return moments_[(block * kMoments + moment) * kMotionLanes + column % kMotionLanes];
  }

  size_t MomentsAt(int block) const { return static_cast<size_t>(block) * kMoments * kMotionLanes; }

  MotionColumns ColumnsOf(int block) const {
    const auto at = [block](const std::vector<float>& values) {
      return values.data() + static_cast<ptrdiff_t>(block) * kMotionLanes;
    };
    return {at(waves_[0]), at(waves_[1]), at(waves_[2]), at(waves_[3]),
            at(nearness_), at(aside_),    at(along_)};
  }

  // Where the columns of a come from in b, at `p`.
  ColumnMap MapColumns(const Parameters& p) {
    ColumnMap map;
    const auto columns_per_rad = static_cast<float>(columns_per_rad_);
    const auto rows_per_rad = static_cast<float>(rows_per_rad_);
    const Eigen::Matrix<float, kParameters, 1> q = p.cast<float>();
    for (int j = 0; j < blocks_ * kMotionLanes; ++j) {
      const float c = waves_[0][j];
      const float s = waves_[1][j];
      nearness_[j] = 1 + q[6] * c + q[7] * s + q[8] * waves_[2][j] + q[9] * waves_[3][j];
      aside_[j] = q[1] * s - q[2] * c;
      along_[j] = q[1] * c + q[2] * s;
      const float on = (q[0] + nearness_[j] * aside_[j]) * columns_per_rad;
      const float left = std::floor(on);
      const int at = (((j + static_cast<int>(left)) % columns_) + columns_) % columns_;
      map.left.push_back(at);
      map.right.push_back(at + 1 == columns_ ? 0 : at + 1);
      map.part.push_back(on - left);
      map.lift.push_back(nearness_[j] * along_[j] * rows_per_rad);
      map.tilt.push_back((q[3] * c + q[4] * s) * rows_per_rad);
    }
    return map;
  }

  // A pixel's sideways shift depends only on its column.
  void Turn(const ColumnMap& map) {
    for (int block = 0; block < blocks_; ++block) {
      const int column = block * kMotionLanes;
      const size_t at = At(0, column);
      kernels_.turn(
          {rows_, columns_, b_.data(), map.left.data() + column, map.right.data() + column,
           map.part.data() + column, static_cast<float>(columns_per_rad_)},
          turned_.data() + at, slope_.data() + at);
    }
  }

  MotionBlock BlockOf(int block, const ColumnMap& map, const Parameters& p) const {
    const int column = block * kMotionLanes;
    const size_t at = At(0, column);
    return {.rows = rows_,
            .lift = lifts_.data(),
            .a = a_.data() + at,
            .b = turned_.data() + at,
            .slope = slope_.data() + at,
            .lifts = map.lift.data() + column,
            .tilts = map.tilt.data() + column,
            .inside = inside_.data() + column,
            .gain = static_cast<float>(1 + p[kGain]),
            .rows_per_rad = static_cast<float>(rows_per_rad_)};
  }

  MotionPixels PixelsOf(int block) {
    const size_t at = At(0, block * kMotionLanes);
    return {residual_.data() + at, u_.data() + at, v_.data() + at, weight_.data() + at};
  }

  // Residuals and slopes at `p`, their sigma and the moments.
  void Look(const Parameters& p, size_t median_samples) {
    const ColumnMap map = MapColumns(p);
    Turn(map);
    for (int i = 0; i < blocks_; ++i) kernels_.sample(BlockOf(i, map, p), PixelsOf(i));
    const double median = MedianMagnitude(residual_, weight_, median_samples);
    sigma_ = std::max(kSigmaOfMedian * median, 1e-9);
    const auto per_sigma = static_cast<float>(1 / (options_.cauchy_sigmas * sigma_));
    for (int i = 0; i < blocks_; ++i) {
      kernels_.sum(BlockOf(i, map, p), PixelsOf(i), per_sigma, moments_.data() + MomentsAt(i));
    }
  }

  const RowImage& b_;
  const SmallMotionOptions& options_;
  int rows_;
  int columns_;
  int blocks_;
  double rows_per_rad_;
  double columns_per_rad_;
  std::array<std::vector<float>, kWaves> waves_;  // of each column: cos t, sin t, cos 2t, sin 2t
  std::vector<float> nearness_;                   // at the last parameters, with the next two
  std::vector<float> aside_;                      // MotionColumns
  std::vector<float> along_;
  std::vector<float> inside_;  // of each column
  std::vector<float> lifts_;   // sin e cos e of each row
  MotionKernels kernels_ = FastestMotionKernels();
  Pixels a_;
  Pixels turned_;  // b's columns, and their slopes
  Pixels slope_;
  Pixels residual_;
  Pixels u_;
  Pixels v_;
  Pixels weight_;
  std::vector<float> moments_;  // of each block
  double sigma_ = 0;
  Information information_ = Information::Zero();
  Parameters gradient_ = Parameters::Zero();
};

// The image of the frequencies below `frequencies` without the rows' means, which don't turn.
RowImage Ripples(const RowSpectra& spectra, int frequencies, double turn_rad) {
  RowImage image =
      RebuildTurned(spectra, frequencies, kColumnsPerFrequency * frequencies, turn_rad);
  image.colwise() -= image.rowwise().mean();
  return image;
}

// What is known of the motion between two stages.
struct Estimate {
  double turn_rad = 0;
  Parameters rest = Parameters::Zero();  // whose turn is 0: b is turned exactly, by the phases
};

class Refinement {
 public:
  Refinement(const FourierSignature& a, const FourierSignature& b, const ElevationBand& band,
             const SmallMotionOptions& options)
      : band_(band),
        options_(options),
        frequencies_(
            std::min({options.fine_frequencies, CommonFrequencies(a), CommonFrequencies(b)})),
        a_(ComputeSpectra(a, frequencies_)),
        b_(ComputeSpectra(b, frequencies_)) {}

  SmallMotion Run(double turn_rad, std::optional<StillStart> still) const {
    Estimate estimate{turn_rad};
    for (int stage = std::min(options_.coarse_frequencies, frequencies_);;
         stage = std::min(2 * stage, frequencies_)) {
      const RowImage of_a = Ripples(a_, stage, 0);
      const double correlation = Settle(of_a, stage, estimate);
      if (still && stage >= std::min(still->frequencies, frequencies_)) {
        Estimate other{still->turn_rad};
        if (Settle(of_a, stage, other) > correlation) estimate = other;
        still.reset();
      }
      if (stage == frequencies_) return MotionAt(of_a, stage, estimate);
    }
  }

 private:
  // Gauss-Newton steps, until they are small beside the stage's pixels. The correlation before the
  // last one.
  double Settle(const RowImage& of_a, int stage, Estimate& estimate) const {
    const RowImage of_b = Ripples(b_, stage, estimate.turn_rad);
    Stage images(of_a, of_b, band_, options_);
    const double settled_rad = options_.settled_pixels * 2 * kPi / (kColumnsPerFrequency * stage);
    Parameters& p = estimate.rest;
    for (int i = 0; i < options_.steps; ++i) {
      images.Linearise(p, kStepSamples);
      const Parameters step = images.Step(p);
      p += step;
      if (step.head<kGain>().lpNorm<Eigen::Infinity>() < settled_rad) break;
    }
    estimate.turn_rad += p[0];
    p[0] = 0;
    return images.Correlation();
  }

  SmallMotion MotionAt(const RowImage& of_a, int stage, const Estimate& estimate) const {
    const RowImage of_b = Ripples(b_, stage, estimate.turn_rad);
    Stage images(of_a, of_b, band_, options_);
    images.Linearise(estimate.rest, kFinalSamples);
    images.Step(estimate.rest);
    const Information covariance = images.Covariance();
    SmallMotion result;
    result.turn_rad = estimate.turn_rad;
    result.motion = estimate.rest.segment<2>(1);
    result.turn_sigma_rad = std::sqrt(covariance(0, 0));
    result.motion_covariance = covariance.block<2, 2>(1, 1);
    result.correlation = images.Correlation();
    return result;
  }

  const ElevationBand& band_;
  const SmallMotionOptions& options_;
  int frequencies_;
  RowSpectra a_;
  RowSpectra b_;
};

}  // namespace

void SmallMotionOptions::Check() const { CheckFields("small_motion", *this); }

SmallMotion RefineSmallMotion(const FourierSignature& a, const FourierSignature& b,
                              const ElevationBand& band, double turn_rad,
                              const SmallMotionOptions& options,
                              const std::optional<StillStart>& still) {
  options.Check();
  WS_CHECK(a.magnitudes.rows() == b.magnitudes.rows() && a.magnitudes.rows() >= 2,
           "signatures of different rows, or of one");
  return Refinement(a, b, band, options).Run(turn_rad, still);
}

}  // namespace waystone
