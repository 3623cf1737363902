// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/plane_fit.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/linear_algebra.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

constexpr int kPlaneSteps = 12;
constexpr double kInlierSigmas = 3;
// A second extent of the points below this share of the first means a line.
constexpr double kLeastExtent = 1e-4;
constexpr double kMadToSigma = 1.4826;

double VarianceAcross(const UncertainPoint& point, const Eigen::Vector3d& normal) {
  const double along = normal.dot(point.along);
  return along * along + point.across * point.across;
}

double DistanceFrom(const FittedPlane& plane, const UncertainPoint& point) {
  return plane.normal.dot(point.x) - plane.distance;
}

struct WeightedMoments {
  double weight = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
};

WeightedMoments ComputeMoments(const std::vector<UncertainPoint>& points,
                               const std::vector<double>& weights) {
  WeightedMoments moments;
  for (size_t i = 0; i < points.size(); ++i) {
    moments.weight += weights[i];
    moments.mean += weights[i] * points[i].x;
  }
  moments.mean /= moments.weight;
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d x = points[i].x - moments.mean;
    moments.scatter += weights[i] * x * x.transpose();
  }
  return moments;
}

// The standard deviation that the residuals have beyond the points' own.
double EstimateFlatness(const FittedPlane& plane, const std::vector<UncertainPoint>& points) {
  std::vector<double> distances;
  std::vector<double> own;
  for (const UncertainPoint& point : points) {
    distances.push_back(std::abs(DistanceFrom(plane, point)));
    own.push_back(VarianceAcross(point, plane.normal));
  }
  const double spread = kMadToSigma * Median(distances);
  return std::sqrt(std::max(0.0, spread * spread - Median(own)));
}

// Of (n, d) by the tilt about the centre of the points and their distance there.
Eigen::Matrix4d ComputeCovariance(const SymmetricEigen& extents, const WeightedMoments& moments) {
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  for (int axis = 1; axis <= 2; ++axis) {
    Eigen::Vector4d tilt;
    tilt << extents.vectors.col(axis), extents.vectors.col(axis).dot(moments.mean);
    covariance += tilt * tilt.transpose() / extents.values(axis);
  }
  covariance(3, 3) += 1 / moments.weight;
  return covariance;
}

}  // namespace

std::optional<FittedPlane> FitPlane(const std::vector<UncertainPoint>& points, int min_points) {
  if (std::ssize(points) < min_points) return std::nullopt;
  FittedPlane plane;
  std::vector<double> weights(points.size(), 1.0);
  for (int step = 0; step < kPlaneSteps; ++step) {
    const WeightedMoments moments = ComputeMoments(points, weights);
    const SymmetricEigen extents = DecomposeSymmetric(moments.scatter);
    if (!extents.converged || !(extents.values(1) > kLeastExtent * extents.values(2))) return {};
    plane.normal = extents.vectors.col(0);
    plane.distance = plane.normal.dot(moments.mean);
    plane.covariance = ComputeCovariance(extents, moments);
    plane.flatness = EstimateFlatness(plane, points);
    for (size_t i = 0; i < points.size(); ++i) {
      const double variance =
          VarianceAcross(points[i], plane.normal) + plane.flatness * plane.flatness;
      const double distance = DistanceFrom(plane, points[i]);
      weights[i] = 1 / (variance + distance * distance / (kInlierSigmas * kInlierSigmas / 4));
    }
  }
  for (const UncertainPoint& point : points) {
    const double variance = VarianceAcross(point, plane.normal) + plane.flatness * plane.flatness;
    plane.inliers +=
        std::abs(DistanceFrom(plane, point)) <= kInlierSigmas * std::sqrt(variance) ? 1 : 0;
  }
  if (plane.inliers < min_points) return std::nullopt;
  return plane;
}

std::optional<UncertainDepth> MeetPlane(const Eigen::Isometry3d& frame_from_camera,
                                        const Eigen::Vector3d& ray, const FittedPlane& plane) {
  const Eigen::Vector3d direction = frame_from_camera.linear() * ray;
  const double slope = plane.normal.dot(direction);
  const Eigen::Vector3d centre = frame_from_camera.translation();
  const double depth = (plane.distance - plane.normal.dot(centre)) / slope;
  if (!(depth > 0) || !std::isfinite(depth)) return std::nullopt;
  Eigen::Vector4d gradient;
  gradient << centre + depth * direction, -1;
  const double variance =
      gradient.dot(plane.covariance * gradient) + plane.flatness * plane.flatness;
  return UncertainDepth{depth, std::sqrt(variance) / (std::abs(slope) * depth)};
}

void TurnAway(const Eigen::Isometry3d& frame_from_camera, Eigen::Vector3d& normal,
              double& distance) {
  if (distance >= normal.dot(frame_from_camera.translation())) return;
  normal = -normal;
  distance = -distance;
}

}  // namespace waystone
