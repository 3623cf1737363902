// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/relative_rotation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/random.h"
#include "core/geometry/decompose_homography.h"
#include "core/geometry/linear_algebra.h"
#include "core/geometry/rotation.h"
#include "core/robust/false_alarms.h"
#include "core/robust/lo_ransac.h"
#include "core/two_view/epipolar.h"
#include "core/two_view/five_point.h"

namespace waystone {
namespace {

constexpr int kSample = 5;
constexpr double kTiny = 1e-12;
// Length of a step at which refinement has converged, rad.
constexpr double kArrived = 1e-8;
// Refits of a promising sample on its growing inliers.
constexpr int kLocalRounds = 3;
// The variance of a translation that the rays don't constrain (its direction is a unit vector).
constexpr double kFreeVariance = 1.0;

using Matrix5d = Eigen::Matrix<double, 5, 5>;

// Whether the point that both rays see lies ahead on both, or too far away to tell.
bool Ahead(const Motion& motion, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
           double max_error) {
  const Eigen::Vector3d ra = motion.b_from_a * a;
  const Eigen::Vector3d parallax = ra.cross(b);
  if (parallax.norm() < max_error && ra.dot(b) > 0) return true;
  // s_b b = s_a R a + t, crossed with b and with R a.
  return motion.translation.cross(b).dot(parallax) < 0 &&
         motion.translation.cross(ra).dot(parallax) < 0;
}

double ScoreEssential(const MatchedRays& rays, const Eigen::Matrix3d& e, double max_error) {
  double score = 0;
  for (int i = 0; i < rays.size(); ++i) {
    const double ratio = EpipolarError(e, rays.a[i], rays.b[i]) / max_error;
    score += std::max(0.0, 1 - ratio * ratio);
  }
  return score;
}

struct Fit {
  Motion motion{Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitZ()};
  std::vector<int> inliers;
  double score = 0;
};

Fit EvaluateMotion(const MatchedRays& rays, const Motion& motion, double max_error) {
  Fit fit{.motion = motion, .inliers = {}};
  const Eigen::Matrix3d e = EssentialMatrix(motion);
  for (int i = 0; i < rays.size(); ++i) {
    const double ratio = EpipolarError(e, rays.a[i], rays.b[i]) / max_error;
    if (!(ratio < 1) || !Ahead(motion, rays.a[i], rays.b[i], max_error)) continue;
    fit.inliers.push_back(i);
    fit.score += 1 - ratio * ratio;
  }
  return fit;
}

// The equations of a step (w, s): R becomes exp(w) R and t becomes t + basis s.
struct Equations {
  Matrix5d h = Matrix5d::Zero();
  Vector5d g = Vector5d::Zero();
  double error2 = 0;  // weighted sum of squared errors, rad^2
  double weight = 0;
};

// Cauchy's kernel at half the largest error.
Equations Linearise(const MatchedRays& rays, const std::vector<int>& rows, const Motion& motion,
                    const Eigen::Matrix<double, 3, 2>& basis, double max_error) {
  Equations sum;
  const Eigen::Matrix3d e = EssentialMatrix(motion);
  for (const int i : rows) {
    const auto [error, j] = LineariseEpipolar(motion, e, basis, rays.a[i], rays.b[i]);
    const double ratio = 2 * error / max_error;
    const double weight = 1 / (1 + ratio * ratio);
    sum.h += weight * j * j.transpose();
    sum.g += weight * error * j;
    sum.error2 += weight * error * error;
    sum.weight += weight;
  }
  return sum;
}

// Keeps an unconstrained translation from making the equations singular, in the errors' unit.
Matrix5d Damping(double max_error) {
  return Matrix5d::Identity() * (max_error * max_error / kFreeVariance);
}

Motion Refine(const MatchedRays& rays, const std::vector<int>& rows, Motion motion,
              const RelativeOptions& options) {
  for (int step = 0; step < options.max_steps; ++step) {
    const Eigen::Matrix<double, 3, 2> basis = TangentBasis(motion.translation);
    const Equations sum = Linearise(rays, rows, motion, basis, options.max_error_rad);
    const Vector5d x = -SolveSymmetric(sum.h + Damping(options.max_error_rad), sum.g);
    if (!x.allFinite()) break;
    motion.b_from_a = RotationByVector(x.head<3>()) * motion.b_from_a;
    motion.translation = (motion.translation + basis * x.tail<2>()).normalized();
    if (x.norm() < kArrived) break;
  }
  motion.b_from_a = Eigen::Quaterniond(motion.b_from_a).normalized().toRotationMatrix();
  return motion;
}

// Refits on its own inliers as long as the score improves.
Fit LocalOptimize(const MatchedRays& rays, Fit fit, const RelativeOptions& options) {
  for (int round = 0; round < kLocalRounds; ++round) {
    if (static_cast<int>(fit.inliers.size()) < kSample) break;
    const Motion better = Refine(rays, fit.inliers, fit.motion, options);
    Fit next = EvaluateMotion(rays, better, options.max_error_rad);
    if (next.score <= fit.score) break;
    fit = std::move(next);
  }
  return fit;
}

Fit BestMotion(const MatchedRays& rays, const Eigen::Matrix3d& essential, double max_error) {
  Fit best;
  for (const Motion& motion : DecomposeEssential(essential)) {
    Fit fit = EvaluateMotion(rays, motion, max_error);
    if (fit.score > best.score) best = std::move(fit);
  }
  return best;
}

using RaySample = std::array<int, kSample>;

// Five different rows, for RunLoRansac.
class RaySampler {
 public:
  explicit RaySampler(int rows) : rows_(rows) {}

  std::optional<RaySample> Draw(Random& random) const {
    RaySample sample;
    for (int i = 0; i < kSample; ++i) {
      do {
        sample[i] = random.Below(rows_);
      } while (std::find(sample.begin(), sample.begin() + i, sample[i]) != sample.begin() + i);
    }
    return sample;
  }

 private:
  int rows_;
};

// Essential matrices of five rays, of which the best motion is refined, for RunLoRansac.
class MotionEstimator {
 public:
  MotionEstimator(const MatchedRays& rays, const RelativeOptions& options)
      : rays_(rays), options_(options) {}

  std::vector<Eigen::Matrix3d> Estimate(const RaySample& sample) const {
    std::array<Eigen::Vector3d, kSample> a;
    std::array<Eigen::Vector3d, kSample> b;
    for (int i = 0; i < kSample; ++i) {
      a[i] = rays_.a[sample[i]];
      b[i] = rays_.b[sample[i]];
    }
    return SolveFivePoints(a, b);
  }

  double Score(const Eigen::Matrix3d& essential) const {
    return ScoreEssential(rays_, essential, options_.max_error_rad);
  }

  Fit Refine(const Eigen::Matrix3d& essential) const {
    return LocalOptimize(rays_, BestMotion(rays_, essential, options_.max_error_rad), options_);
  }

  double SampleProbability(const Fit& fit) const {
    return std::pow(static_cast<double>(fit.inliers.size()) / rays_.size(), kSample);
  }

 private:
  const MatchedRays& rays_;
  const RelativeOptions& options_;
};

// The probability that an unrelated match fits the motion: the share of fits when a's rays are
// paired with those of other matches in b. Rays aren't spread evenly over the sphere: near the
// horizon, or on one object, many more fit than the bound's share of the sphere.
double ChanceOfFitting(const MatchedRays& rays, const Motion& motion, double max_error) {
  constexpr int kPairings = 64;
  const Eigen::Matrix3d essential = EssentialMatrix(motion);
  const int n = rays.size();
  int fits = 0;
  int pairs = 0;
  for (int k = 0; k < std::min(kPairings, n - 1); ++k) {
    const int shift = 1 + static_cast<int>(int64_t{k} * (n - 1) / std::min(kPairings, n - 1));
    for (int i = 0; i < n; ++i) {
      const int j = (i + shift) % n;
      if ((rays.b[i] - rays.b[j]).norm() <= max_error) continue;  // the same point twice
      ++pairs;
      if (EpipolarError(essential, rays.a[i], rays.b[j]) <= max_error) ++fits;
    }
  }
  // Sampson's distance halves the square: each of two rays moves, so the band is wider by sqrt 2.
  const double even = std::sin(std::min(1.0, std::sqrt(2.0) * max_error));
  return pairs == 0 ? 1 : std::max(even, fits / static_cast<double>(pairs));
}

double Log10Chance(const MatchedRays& rays, const Fit& fit, double max_error) {
  const double alpha = ChanceOfFitting(rays, fit.motion, max_error);
  const double expected = LogFalseAlarms(rays.size(), static_cast<int>(fit.inliers.size()), alpha,
                                         {.sample = kSample, .solutions = 10});
  return std::min(0.0, expected / std::log(10.0));
}

// The errors' variance is measured, but no better than a hundredth of the bound: with few inliers
// they may fit by accident.
Eigen::Matrix3d EstimateCovariance(const MatchedRays& rays, const Fit& fit, double max_error) {
  const Equations sum =
      Linearise(rays, fit.inliers, fit.motion, TangentBasis(fit.motion.translation), max_error);
  const double freedom = std::max(1.0, sum.weight - kSample);
  const double variance = std::max(sum.error2 / freedom, 1e-4 * max_error * max_error);
  const Matrix5d inverse = InvertSymmetric(sum.h + variance / kFreeVariance * Matrix5d::Identity());
  return variance * inverse.topLeftCorner<3, 3>();
}

// The matrix that takes rays of a plane to each other, b ~ H a, by the direct linear transform over
// these rows; its sign is that of points ahead.
Eigen::Matrix3d FitPlaneHomography(const MatchedRays& rays, const std::vector<int>& rows) {
  Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Zero();
  for (const int i : rows) {
    const Eigen::Matrix3d cross = CrossMatrix(rays.b[i]);
    Eigen::Matrix<double, 3, 9> j;  // b x H a, with H column by column
    for (int k = 0; k < 3; ++k) j.middleCols<3>(3 * k) = rays.a[i](k) * cross;
    sum += j.transpose() * j;
  }
  const Eigen::MatrixXd vectors = DecomposeSymmetric(sum).vectors;
  const Eigen::Matrix3d h = Eigen::Map<const Eigen::Matrix3d>(vectors.data());
  double ahead = 0;
  for (const int i : rows) ahead += rays.b[i].dot(h * rays.a[i]);
  return ahead < 0 ? Eigen::Matrix3d(-h) : h;
}

// The other motion that the inliers' plane allows, where it explains them as well.
std::optional<RelativePose::Rival> FindRival(const MatchedRays& rays, const Fit& best,
                                             const RelativeOptions& options) {
  std::optional<RelativePose::Rival> rival;
  double most = options.max_rival * best.score;
  for (const PlaneMotion& plane : DecomposeHomography(FitPlaneHomography(rays, best.inliers))) {
    if (plane.translation.norm() < kTiny) continue;
    for (const int sign : {1, -1}) {
      const Motion motion{plane.b_from_a, sign * plane.translation.normalized()};
      const Fit fit =
          LocalOptimize(rays, EvaluateMotion(rays, motion, options.max_error_rad), options);
      const Eigen::AngleAxisd turned(fit.motion.b_from_a * best.motion.b_from_a.transpose());
      if (fit.score < most || turned.angle() < options.rival_angle_rad) continue;
      most = fit.score;
      rival = {fit.motion.b_from_a, fit.motion.translation};
    }
  }
  return rival;
}

RelativeError JudgePose(const RelativePose& pose, const RelativeOptions& options) {
  if (static_cast<int>(pose.inliers.size()) < options.min_inliers) {
    return RelativeError::kFewInliers;
  }
  if (pose.log10_chance > options.max_log10_chance) return RelativeError::kChance;
  if (pose.sigma_rad() > options.max_sigma_rad) return RelativeError::kUncertain;
  if (pose.rival) return RelativeError::kPlanar;
  return RelativeError::kNone;
}

}  // namespace

void RelativeOptions::Check() const { CheckFields("relative", *this); }

std::string_view NameOf(RelativeError error) {
  switch (error) {
    case RelativeError::kNone:
      return "none";
    case RelativeError::kFewInliers:
      return "few_inliers";
    case RelativeError::kChance:
      return "chance";
    case RelativeError::kPlanar:
      return "planar";
    default:
      return "uncertain";
  }
}

double RelativePose::sigma_rad() const { return WorstAxisSigma(covariance); }

double EpipolarError(const Eigen::Matrix3d& b_from_a, const Eigen::Vector3d& translation,
                     const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return EpipolarError(EssentialMatrix({b_from_a, translation}), a, b);
}

RelativePose FindRelativePose(const MatchedRays& rays, const RelativeOptions& options) {
  options.Check();
  RelativePose pose;
  if (rays.size() < options.min_inliers) return pose;
  RaySampler sampler(rays.size());
  Random random(options.seed);
  const auto [best, samples] = RunLoRansac(sampler, MotionEstimator(rays, options),
                                           {.confidence = options.confidence,
                                            .max_samples = options.max_samples,
                                            .min_samples = options.min_samples},
                                           random);
  pose.samples = samples;
  if (best.inliers.empty()) return pose;
  pose.b_from_a = best.motion.b_from_a;
  pose.translation = best.motion.translation;
  pose.inliers = best.inliers;
  pose.log10_chance = Log10Chance(rays, best, options.max_error_rad);
  pose.covariance = EstimateCovariance(rays, best, options.max_error_rad);
  if (static_cast<int>(best.inliers.size()) >= options.min_inliers) {
    pose.rival = FindRival(rays, best, options);
  }
  pose.error = JudgePose(pose, options);
  return pose;
}

}  // namespace waystone
