// SPDX-License-Identifier: Apache-2.0
#include "core/camera_pose/absolute_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "core/base/random.h"
#include "core/geometry/linear_algebra.h"
#include "core/geometry/rotation.h"
#include "core/geometry/tangent_basis.h"
#include "core/robust/lo_ransac.h"

namespace waystone {
namespace {

constexpr int kPoseSample = 3;
constexpr int kPoseRounds = 3;  // refits of a pose on its growing inliers
// Share of the best score above which a pose is refined: points are imprecise, and so is the pose
// from three right matches.
constexpr double kRefineShare = 0.7;
constexpr int kSampleSteps = 3;  // of a refit within RANSAC, whose best pose is refined to the end
constexpr double kPoseArrived = 1e-6;  // a step in the map's unit and in rad
constexpr double kCauchySigmas = 2;
// A pose whose rotation has a larger sigma is left open by its matches.
constexpr double kLargestSigma_rad = 0.5;

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// A match at a pose: its error on the image plane across its ray, and the derivatives.
struct LinearSighting {
  Vector2d error = Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Matrix<double, 2, 3> by_point;  // in the world
  Eigen::Matrix2d information;           // inverse covariance of the error

  double squared_sigmas() const { return error.dot(information * error); }
};

LinearSighting LinearisePoint(const PointSighting& sighting, const Isometry3d& camera_from_world) {
  LinearSighting linear;
  const Vector3d x = camera_from_world * sighting.point;
  const double ahead = sighting.ray.dot(x);
  linear.information.setIdentity();
  linear.by_point.setZero();
  if (!(ahead > 0)) return linear;
  const Eigen::Matrix<double, 3, 2> basis = TangentBasis(sighting.ray);
  linear.error = basis.transpose() * x / ahead;
  linear.by_point = (basis.transpose() - linear.error * sighting.ray.transpose()) / ahead *
                    camera_from_world.linear();
  const Vector2d along = linear.by_point * sighting.along;
  const Eigen::Matrix2d covariance =
      sighting.sigma_rad * sighting.sigma_rad * Eigen::Matrix2d::Identity() +
      sighting.across * sighting.across * linear.by_point * linear.by_point.transpose() +
      along * along.transpose();
  linear.information = covariance.inverse();
  return linear;
}

// The equations of a step (p, w): the camera's centre moves by p, and world_from_camera is turned
// to exp(w) world_from_camera. A point then appears moved by -p - w x (point - centre).
struct PoseEquations {
  Matrix6d h = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double error2 = 0;
  double weight = 0;
};

Eigen::Matrix<double, 2, 6> JacobianOf(const LinearSighting& linear, const PointSighting& sighting,
                                       const Isometry3d& world_from_camera) {
  Eigen::Matrix<double, 2, 6> jacobian;
  jacobian.leftCols<3>() = -linear.by_point;
  jacobian.rightCols<3>() =
      linear.by_point * CrossMatrix(sighting.point - world_from_camera.translation());
  return jacobian;
}

PoseEquations LinearisePose(std::span<const PointSighting> sightings, const std::vector<int>& rows,
                            const Isometry3d& world_from_camera, bool robust) {
  PoseEquations sum;
  const Isometry3d camera_from_world = world_from_camera.inverse();
  for (const int row : rows) {
    const LinearSighting linear = LinearisePoint(sightings[row], camera_from_world);
    const double error2 = linear.squared_sigmas();
    if (!std::isfinite(error2)) continue;
    const Eigen::Matrix<double, 2, 6> j = JacobianOf(linear, sightings[row], world_from_camera);
    const double weight =
        sightings[row].weight * (robust ? 1 / (1 + error2 / (kCauchySigmas * kCauchySigmas)) : 1.0);
    sum.h += weight * j.transpose() * linear.information * j;
    sum.g += weight * j.transpose() * linear.information * linear.error;
    sum.error2 += weight * error2;
    sum.weight += weight;
  }
  return sum;
}

void StepPose(const Vector6d& step, Isometry3d& world_from_camera) {
  world_from_camera.translation() += step.head<3>();
  world_from_camera.linear() =
      Eigen::Quaterniond(RotationByVector(step.tail<3>()) * world_from_camera.linear())
          .normalized()
          .toRotationMatrix();
}

// A pose with its inliers.
struct PoseFit {
  Isometry3d world_from_camera = Isometry3d::Identity();
  std::vector<int> inliers;
  double score = 0;
};

// What a match's likelihood loses, in squared sigmas, because its point is uncertain: its error may
// then be anywhere in a larger region. Without this, a pose so near the points or so far to the
// side that their uncertainty covers the image would explain every match.
double SpreadCost(const LinearSighting& linear, double sigma_rad) {
  return -std::log(linear.information.determinant() * std::pow(sigma_rad, 4));
}

PoseFit EvaluatePose(std::span<const PointSighting> sightings, const Isometry3d& world_from_camera,
                     double max_sigmas) {
  PoseFit fit{.world_from_camera = world_from_camera, .inliers = {}};
  const Isometry3d camera_from_world = world_from_camera.inverse();
  for (int i = 0; i < std::ssize(sightings); ++i) {
    const LinearSighting linear = LinearisePoint(sightings[i], camera_from_world);
    const double ratio2 = (linear.squared_sigmas() + SpreadCost(linear, sightings[i].sigma_rad)) /
                          (max_sigmas * max_sigmas);
    if (!(ratio2 < 1)) continue;
    fit.inliers.push_back(i);
    fit.score += sightings[i].weight * (1 - ratio2);
  }
  return fit;
}

Isometry3d RefineOn(std::span<const PointSighting> sightings, const std::vector<int>& rows,
                    Isometry3d pose, int max_steps) {
  for (int step = 0; step < max_steps; ++step) {
    const PoseEquations sum = LinearisePose(sightings, rows, pose, true);
    const Vector6d change = -SolveSymmetric(sum.h, sum.g);
    if (!change.allFinite()) break;
    StepPose(change, pose);
    if (change.norm() < kPoseArrived) break;
  }
  return pose;
}

PoseFit OptimizePose(std::span<const PointSighting> sightings, PoseFit fit, int max_steps,
                     const AbsolutePoseOptions& options) {
  for (int round = 0; round < kPoseRounds; ++round) {
    if (std::ssize(fit.inliers) < kPoseSample + 1) break;
    const Isometry3d better = RefineOn(sightings, fit.inliers, fit.world_from_camera, max_steps);
    PoseFit next = EvaluatePose(sightings, better, options.max_sigmas);
    if (next.score <= fit.score) break;
    fit = std::move(next);
  }
  return fit;
}

using PoseSample = std::array<int, kPoseSample>;

// Three different rows, for RunLoRansac.
class PoseSampler {
 public:
  explicit PoseSampler(int rows) : rows_(rows) {}

  std::optional<PoseSample> Draw(Random& random) const {
    const PoseSample sample{random.Below(rows_), random.Below(rows_), random.Below(rows_)};
    if (sample[0] == sample[1] || sample[0] == sample[2] || sample[1] == sample[2]) return {};
    return sample;
  }

 private:
  int rows_;
};

// The poses of three matches, for RunLoRansac.
class PoseEstimator {
 public:
  PoseEstimator(std::span<const PointSighting> sightings, const AbsolutePoseOptions& options)
      : sightings_(sightings), options_(options) {}

  std::vector<Isometry3d> Estimate(const PoseSample& sample) const {
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (const int row : sample) {
      const auto& [point, ray] = std::pair(sightings_[row].point, sightings_[row].ray);
      if (ray.z() <= 0) return {};  // not on the solver's image plane
      points.emplace_back(point.x(), point.y(), point.z());
      pixels.emplace_back(ray.x() / ray.z(), ray.y() / ray.z());
    }
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    cv::solveP3P(points, pixels, cv::Matx33d::eye(), cv::noArray(), rotations, translations,
                 cv::SOLVEPNP_AP3P);
    std::vector<Isometry3d> poses;
    for (size_t i = 0; i < rotations.size(); ++i) {
      const Eigen::Map<const Vector3d> turn(rotations[i].ptr<double>());
      const Eigen::Map<const Vector3d> shift(translations[i].ptr<double>());
      if (!turn.allFinite() || !shift.allFinite()) continue;
      Isometry3d camera_from_world = Isometry3d::Identity();
      camera_from_world.linear() = RotationByVector(turn);
      camera_from_world.translation() = shift;
      poses.push_back(camera_from_world.inverse());
    }
    return poses;
  }

  double Score(const Isometry3d& pose) const {
    return EvaluatePose(sightings_, pose, options_.max_sigmas).score;
  }

  PoseFit Refine(const Isometry3d& pose) const {
    return OptimizePose(sightings_, EvaluatePose(sightings_, pose, options_.max_sigmas),
                        std::min(kSampleSteps, options_.max_steps), options_);
  }

  double SampleProbability(const PoseFit& fit) const {
    return std::pow(static_cast<double>(fit.inliers.size()) / std::ssize(sightings_), kPoseSample);
  }

 private:
  std::span<const PointSighting> sightings_;
  const AbsolutePoseOptions& options_;
};

// By how much errors that neighbouring rays share enlarge the covariance, at least 1: the variance
// of the gradient summed over cells of the view, which neither cancels such errors nor takes them
// for independent (Conley, J. Econometrics 1999), over that of independent errors.
double ComputeDesignEffect(std::span<const PointSighting> sightings, const AbsolutePose& pose,
                           const Matrix6d& inverse_h) {
  constexpr double kCell_rad = 0.2;
  constexpr int kLeastCells = 4;
  std::map<std::array<int, 3>, Vector6d> gradients;
  const Isometry3d camera_from_world = pose.world_from_camera.inverse();
  for (const int row : pose.inliers) {
    const PointSighting& sighting = sightings[row];
    const LinearSighting linear = LinearisePoint(sighting, camera_from_world);
    const auto cell = [&](int axis) {
      return static_cast<int>(std::floor(sighting.ray(axis) / kCell_rad));
    };
    Vector6d& sum =
        gradients.try_emplace({cell(0), cell(1), cell(2)}, Vector6d::Zero()).first->second;
    sum += sighting.weight * JacobianOf(linear, sighting, pose.world_from_camera).transpose() *
           linear.information * linear.error;
  }
  const auto cells = static_cast<int>(gradients.size());
  if (cells < kLeastCells) return 1;
  Matrix6d variance = Matrix6d::Zero();
  for (const auto& [cell, gradient] : gradients) variance += gradient * gradient.transpose();
  const double correction = cells / (cells - 3.0);  // 6 of the 2 * cells coordinates are fitted
  return std::max(1.0, correction * (inverse_h * variance).trace() / (6 * pose.variance));
}

std::optional<AbsolutePose> DescribePose(std::span<const PointSighting> sightings, PoseFit fit,
                                         const AbsolutePoseOptions& options) {
  if (std::ssize(fit.inliers) < options.min_inliers) return std::nullopt;
  AbsolutePose pose{.world_from_camera = fit.world_from_camera, .inliers = std::move(fit.inliers)};
  const PoseEquations sum = LinearisePose(sightings, pose.inliers, pose.world_from_camera, false);
  if (sum.weight < options.min_inliers) return std::nullopt;
  pose.variance = sum.error2 / (2 * sum.weight - 6);
  const Matrix6d inverse_h = InvertSymmetric(sum.h);
  if (!inverse_h.allFinite()) return std::nullopt;
  pose.covariance = pose.variance * ComputeDesignEffect(sightings, pose, inverse_h) * inverse_h;
  const Eigen::Matrix<double, 6, 1> variances = pose.covariance.diagonal();
  if (!pose.covariance.allFinite() || variances.minCoeff() < 0) return std::nullopt;
  if (variances.tail<3>().sum() > kLargestSigma_rad * kLargestSigma_rad) return std::nullopt;
  return pose;
}

}  // namespace

std::optional<AbsolutePose> RefineAbsolutePose(std::span<const PointSighting> sightings,
                                               const Isometry3d& world_from_camera,
                                               const AbsolutePoseOptions& options) {
  const PoseFit start = EvaluatePose(sightings, world_from_camera, options.max_sigmas);
  return DescribePose(sightings, OptimizePose(sightings, start, options.max_steps, options),
                      options);
}

std::optional<AbsolutePose> FindAbsolutePose(std::span<const PointSighting> sightings,
                                             const AbsolutePoseOptions& options) {
  if (std::ssize(sightings) < options.min_inliers) return std::nullopt;
  PoseSampler sampler(static_cast<int>(sightings.size()));
  const PoseEstimator estimator(sightings, options);
  Random random(options.seed);
  const RansacLimits limits{.confidence = options.confidence,
                            .max_samples = options.max_samples,
                            .min_refine_share = kRefineShare};
  auto [best, samples] = RunLoRansac(sampler, estimator, limits, random);
  return DescribePose(
      sightings, OptimizePose(sightings, std::move(best), options.max_steps, options), options);
}

}  // namespace waystone
