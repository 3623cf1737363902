// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/traversability.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/pose2.h"
#include "core/geometry/rotation.h"
#include "core/manhattan/cube_rotations.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

// Median angle by which inliers move in addition to the rotation.
double Parallax(const MatchedRays& rays, const RelativePose& pose) {
  std::vector<double> angles;
  for (const int i : pose.inliers) {
    angles.push_back(AngleBetween(pose.b_from_a * rays.a[i], rays.b[i]));
  }
  return Median(std::move(angles));
}

// Azimuth around the building's vertical as the rig sees it: 0 ahead, growing to the left.
double Azimuth(const Eigen::Vector3d& ray, const Eigen::Vector3d& up) {
  const Eigen::Vector3d left = up.cross(Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d ahead = left.cross(up);
  return std::atan2(ray.dot(left), ray.dot(ahead));
}

Eigen::Vector3d UpOf(const OrientationFrame& frame) {
  if (!frame.rotation) return -Eigen::Vector3d::UnitY();
  return frame.rotation->building_from_rig.conjugate() * Eigen::Vector3d::UnitZ();
}

double Flow(const MatchedRays& rays, const std::vector<int>& inliers, const OrientationFrame& a,
            const OrientationFrame& b) {
  double sum = 0;
  for (const int i : inliers) {
    sum += WrappedAngle(Azimuth(rays.b[i], UpOf(b)) - Azimuth(rays.a[i], UpOf(a)));
  }
  return inliers.empty() ? 0 : sum / static_cast<double>(inliers.size());
}

std::optional<double> Disagreement(const OrientationFrame& a, const OrientationFrame& b,
                                   const RelativePose& pose) {
  if (!a.reliable || !b.reliable) return std::nullopt;
  const Eigen::Matrix3d a_from_axes = a.rotation->building_from_rig.conjugate().toRotationMatrix();
  const Eigen::Matrix3d b_from_axes = b.rotation->building_from_rig.conjugate().toRotationMatrix();
  // Only the axes count, not their numbers: these may differ between sequences.
  const Eigen::Matrix3d nearest = NearestOfCube(b_from_axes, pose.b_from_a * a_from_axes);
  return RotationAngle(nearest * a_from_axes.transpose(), pose.b_from_a);
}

}  // namespace

Traversal TestTraversability(const OrientedFeatures& a, const OrientedFeatures& b,
                             const TraversabilityOptions& options) {
  Traversal traversal;
  if (a.features->size() == 0 || b.features->size() == 0) return traversal;
  const MatchedRays rays = MatchBearings(*a.features, *b.features, options.matching);
  traversal.pose = FindRelativePose(rays, options.relative);
  const RelativePose& pose = traversal.pose;
  traversal.matches = static_cast<int>(pose.inliers.size());
  traversal.flow_rad = Flow(rays, pose.inliers, *a.frame, *b.frame);
  if (!pose.accepted() && !pose.one_of_two()) return traversal;
  traversal.disagreement_rad = Disagreement(*a.frame, *b.frame, pose);
  if (pose.rival) {
    // R_c selects one of a plane's two motions; without it, the one that turns less.
    RelativePose rival = pose;
    rival.b_from_a = pose.rival->b_from_a;
    rival.translation = pose.rival->translation;
    const auto other = Disagreement(*a.frame, *b.frame, rival);
    const Eigen::Matrix3d none = Eigen::Matrix3d::Identity();
    const double turned = RotationAngle(pose.b_from_a, none);
    if (other.value_or(RotationAngle(rival.b_from_a, none)) <
        traversal.disagreement_rad.value_or(turned)) {
      traversal.pose = std::move(rival);
      traversal.disagreement_rad = other;
    }
  }
  traversal.connected = traversal.disagreement_rad.value_or(0) <= options.max_disagreement_rad;
  if (b.frame->rotation && Parallax(rays, pose) >= options.min_parallax_rad) {
    // a's centre lies at t in b's frame: the rig went the other way.
    const Eigen::Vector3d motion = b.frame->rotation->building_from_rig * -pose.translation;
    traversal.motion_rad = std::atan2(motion.y(), motion.x());
  }
  return traversal;
}

}  // namespace waystone
