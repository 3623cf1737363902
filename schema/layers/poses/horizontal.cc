// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/poses/horizontal.h"

#include <Eigen/Geometry>
#include <cmath>

namespace waystone {
namespace {

// The mean direction of the tops of images is off by the pitch of the camera, and most frames have
// an axis along gravity.
Eigen::Vector3d NearAxis(const Eigen::Vector3d& up) {
  const double close = std::cos(20 * EIGEN_PI / 180);
  for (int i = 0; i < 3; ++i) {
    if (std::abs(up[i]) > close) return std::copysign(1.0, up[i]) * Eigen::Vector3d::Unit(i);
  }
  return up;
}

}  // namespace

std::optional<Eigen::Vector3d> EstimateUp(const PoseLayer& layer) {
  constexpr double kLeastMean = 0.5;  // length of the mean; shorter, the images have no common top
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const CameraPose& pose : layer.keyframes) sum -= pose.rotation * Eigen::Vector3d::UnitY();
  for (const CameraPose& pose : layer.nodes) sum -= pose.rotation * Eigen::Vector3d::UnitY();
  const size_t images = layer.keyframes.size() + layer.nodes.size();
  if (images == 0 || sum.norm() < kLeastMean * static_cast<double>(images)) return std::nullopt;
  return sum.normalized();
}

Pose2 Horizontal::Of(const CameraPose& pose) const {
  const Eigen::Vector2d at = Of(pose.position);
  const Eigen::Vector2d ahead = Of(pose.rotation * Eigen::Vector3d::UnitZ());
  return {at.x(), at.y(), std::atan2(ahead.y(), ahead.x())};
}

Horizontal HorizontalOf(const PoseLayer& layer) {
  constexpr double kNearUp = 0.8;  // cosine
  Horizontal view;
  view.up = NearAxis(EstimateUp(layer).value_or(Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d sideways =
      std::abs(view.up.x()) < kNearUp ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  view.right = (sideways - sideways.dot(view.up) * view.up).normalized();
  view.top = view.up.cross(view.right);
  return view;
}

}  // namespace waystone
