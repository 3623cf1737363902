// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/visual_compass.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/linear_algebra.h"
#include "core/geometry/pose2.h"

namespace waystone {
namespace {

constexpr int kNewtonSteps = 5;                             // starting near a smooth peak
constexpr double kUnknown_rad = kPi / std::numbers::sqrt3;  // sigma of a uniform direction

// The sum over the rows of the weighted phase differences of each frequency, over all weights.
std::vector<std::complex<double>> CrossSpectrum(const FourierSignature& a,
                                                const FourierSignature& b,
                                                const PhaseCompassOptions& options) {
  using Values = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int count = std::min({options.frequencies, CommonFrequencies(a), CommonFrequencies(b)});
  const auto of = [&](const HalfMatrix& values) -> Values {
    return values.middleCols(1, count - 1).cast<float>().array();
  };
  const Values products = of(a.magnitudes) * of(b.magnitudes);
  const Values turns = of(a.phases) - of(b.phases);
  // A power by its logarithm, which can be vectorised.
  const auto power = static_cast<float>(options.power);
  const Values weights = (power * products.max(std::numeric_limits<float>::min()).log()).exp();
  // Evaluated before they are summed, again to be vectorised.
  const Values x = weights * turns.cos();
  const Values y = weights * turns.sin();
  const Eigen::ArrayXd re = x.colwise().sum().transpose().cast<double>();
  const Eigen::ArrayXd im = y.colwise().sum().transpose().cast<double>();
  const double all = std::max<double>(weights.sum(), 1e-300);
  std::vector<std::complex<double>> spectrum(count);
  for (int l = 1; l < count; ++l) spectrum[l] = std::complex<double>(re[l - 1], im[l - 1]) / all;
  return spectrum;
}

// The score of a turn and its first two derivatives.
struct Score {
  double value = 0;
  double slope = 0;
  double bend = 0;
};

Score ScoreAt(const std::vector<std::complex<double>>& spectrum, double turn_rad) {
  Score score;
  const std::complex<double> step = std::polar(1.0, -turn_rad);
  std::complex<double> turn = 1;
  for (size_t l = 1; l < spectrum.size(); ++l) {
    const auto frequency = static_cast<double>(l);
    turn *= step;
    const std::complex<double> term = spectrum[l] * turn;
    score.value += term.real();
    score.slope += frequency * term.imag();
    score.bend -= frequency * frequency * term.real();
  }
  return score;
}

// The negative scores of `steps` turns around the circle: a Fourier transform of the spectrum.
std::vector<double> Losses(const std::vector<std::complex<double>>& spectrum, int steps) {
  cv::Mat terms(1, steps, CV_64FC2, cv::Scalar::all(0));
  for (size_t l = 1; l < spectrum.size(); ++l) {
    // Frequencies above steps - 1 alias to lower ones.
    terms.at<cv::Vec2d>(0, static_cast<int>(l) % steps) +=
        cv::Vec2d(spectrum[l].real(), spectrum[l].imag());
  }
  cv::dft(terms, terms);
  std::vector<double> losses(steps);
  for (int i = 0; i < steps; ++i) losses[i] = -terms.at<cv::Vec2d>(0, i)[0];
  return losses;
}

// Newton's steps up to the peak next to `turn_rad`, at most `reach_rad` away.
CompassPeak Refined(const std::vector<std::complex<double>>& spectrum, double turn_rad,
                    double reach_rad) {
  double offset = 0;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Score score = ScoreAt(spectrum, turn_rad + offset);
    if (score.bend >= 0) break;
    offset = std::clamp(offset - score.slope / score.bend, -reach_rad, reach_rad);
  }
  return {WrappedAngle(turn_rad + offset), ScoreAt(spectrum, turn_rad + offset).value};
}

// The index of the least value at least `separation_rad` away from `from`, on a circle.
int LeastBeyond(const std::vector<double>& values, int from, double separation_rad) {
  const int size = static_cast<int>(values.size());
  const double step_rad = 2 * kPi / size;
  int least = -1;
  for (int i = 0; i < size; ++i) {
    const int apart = std::abs(i - from);
    if (std::min(apart, size - apart) * step_rad < separation_rad) continue;
    if (least < 0 || values[i] < values[least]) least = i;
  }
  return least;
}

// The sigma from the angle of the least cost, over a circle of costs, when a hypothesis
// becomes e times less likely by `cost_per_e` (of all columns together). Angles within `near_rad`
// count as right.
double EstimateSpread(const std::vector<double>& costs, double cost_per_e, double near_rad) {
  const auto least = std::ranges::min_element(costs) - costs.begin();
  const auto n = static_cast<double>(costs.size());
  double weights = 0;
  double squares = 0;
  for (size_t i = 0; i < costs.size(); ++i) {
    const double off_rad =
        WrappedAngle((static_cast<double>(i) - static_cast<double>(least)) * 2 * kPi / n);
    const double weight = std::exp(-(costs[i] - costs[least]) * n / cost_per_e);
    weights += weight;
    if (std::abs(off_rad) > near_rad) squares += weight * off_rad * off_rad;
  }
  return std::sqrt(squares / weights);
}

MotionDirection EstimateDirection(const SmallMotion& small, const CompassOptions& options) {
  const double length = small.motion.norm();
  const Eigen::Vector2d across(-small.motion.y(), small.motion.x());
  const double sigma =
      std::sqrt(across.dot(small.motion_covariance * across)) / std::max(length * length, 1e-12);
  return {-std::atan2(small.motion.y(), small.motion.x()),
          std::min(std::hypot(sigma, options.uneven_depth), kUnknown_rad), length};
}

MotionDirection EstimateDirection(const Warping& warping, const CompassOptions& options) {
  const double spread = EstimateSpread(warping.motion_costs, options.cost_per_e, 0);
  return {WrappedAngle(-warping.motion_rad), std::hypot(spread, options.warping_sigma_rad), {}};
}

// The motion over its sigma: chi with two degrees of freedom.
double MotionSigmas(const SmallMotion& small) {
  // Of two equal panoramas the covariance is 0: no motion.
  const Eigen::Vector2d weighed = SolveSymmetric(small.motion_covariance, small.motion);
  return std::sqrt(small.motion.dot(weighed));
}

double EstimateSigma(const SmallMotion& small, const CompassOptions& options) {
  return std::hypot(small.turn_sigma_rad, options.uneven_depth * small.motion.norm());
}

// Starts from the warping search's heading, which is coarse, or that of the phases, which is far
// off after a motion: whichever fits better after refining the coarse one.
SmallMotion BestSmallMotion(const FourierSignature& a, const FourierSignature& b,
                            const Warping& warping, const PhaseCompass& phases,
                            const CompassOptions& options) {
  const double still_rad = phases.best.heading_rad;
  std::optional<StillStart> still;
  if (std::abs(WrappedAngle(still_rad - warping.turn_rad)) <= options.agreement_rad) {
    still = {still_rad, options.still_frequencies};
  }
  return RefineSmallMotion(a, b, options.band, warping.turn_rad, options.small_motion, still);
}

bool Fits(const SmallMotion& small, const Warping& warping, const CompassOptions& options) {
  return small.correlation >= options.min_correlation &&
         std::abs(WrappedAngle(small.turn_rad - warping.turn_rad)) <= options.agreement_rad;
}

}  // namespace

void PhaseCompassOptions::Check() const { CheckFields("phases", *this); }

void CompassOptions::Check() const {
  CheckFields("compass", *this);
  warping.Check();
}

PhaseCompass TurnByPhases(const FourierSignature& a, const FourierSignature& b,
                          const PhaseCompassOptions& options) {
  options.Check();
  WS_CHECK(a.magnitudes.rows() == b.magnitudes.rows(), "signatures of different rows");
  const auto spectrum = CrossSpectrum(a, b, options);
  const double step_rad = 2 * kPi / options.steps;
  const std::vector<double> losses = Losses(spectrum, options.steps);
  const auto best = static_cast<int>(std::ranges::min_element(losses) - losses.begin());
  PhaseCompass compass;
  compass.best = Refined(spectrum, best * step_rad, step_rad);
  const int second = LeastBeyond(losses, best, options.separation_rad);
  compass.runner_up = {WrappedAngle(second * step_rad), -losses[second]};
  compass.sharpness = compass.best.score - compass.runner_up.score;
  return compass;
}

CompassHeading RelativeHeading(const FourierSignature& a, const FourierSignature& b,
                               const CompassOptions& options) {
  options.Check();
  const Warping warping = SearchWarping(a, b, options.band, options.warping);
  const PhaseCompass phases = TurnByPhases(a, b, options.phases);
  const SmallMotion small = BestSmallMotion(a, b, warping, phases, options);
  const auto columns = static_cast<int>(warping.turn_costs.size());
  const double step_rad = 2 * kPi / columns;
  const auto best =
      static_cast<int>(std::ranges::min_element(warping.turn_costs) - warping.turn_costs.begin());
  const int second = LeastBeyond(warping.turn_costs, best, options.separation_rad);
  const double wrong_rad = EstimateSpread(warping.turn_costs, options.cost_per_e, 1.5 * step_rad);
  CompassHeading heading;
  heading.small_motion = Fits(small, warping, options);
  const bool still =
      heading.small_motion && MotionSigmas(small) < options.still_sigmas &&
      std::abs(WrappedAngle(small.turn_rad - phases.best.heading_rad)) <= options.agreement_rad;
  heading.heading_rad = still                  ? phases.best.heading_rad
                        : heading.small_motion ? WrappedAngle(small.turn_rad)
                                               : WrappedAngle(warping.turn_rad);
  heading.sigma_rad = std::hypot(
      wrong_rad, heading.small_motion ? EstimateSigma(small, options) : options.warping_sigma_rad);
  heading.runner_up_rad = WrappedAngle(second * step_rad);
  heading.sharpness = warping.turn_costs[second] - warping.turn_costs[best];
  const MotionDirection motion = heading.small_motion ? EstimateDirection(small, options)
                                                      : EstimateDirection(warping, options);
  if (motion.sigma_rad <= options.max_motion_sigma_rad) heading.motion = motion;
  return heading;
}

}  // namespace waystone
