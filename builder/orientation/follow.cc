// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/follow.h"

#include <cmath>
#include <utility>

#include "core/manhattan/cube_rotations.h"

namespace waystone {
namespace {

// head_from_building of a head that looks along x: x ahead, y to the left, z up.
Eigen::Matrix3d LookingAlongX() {
  Eigen::Matrix3d axes;
  axes.col(0) = Eigen::Vector3d::UnitZ();
  axes.col(1) = -Eigen::Vector3d::UnitX();
  axes.col(2) = -Eigen::Vector3d::UnitY();
  return axes;
}

BuildingRotation RotationOf(const Eigen::Matrix3d& head_from_building,
                            const Eigen::Matrix3d& head_covariance) {
  BuildingRotation rotation;
  Eigen::Quaterniond q(Eigen::Matrix3d(head_from_building.transpose()));
  q.normalize();
  if (q.w() < 0) q.coeffs() *= -1;
  rotation.building_from_head = q;
  // exp(w) R of the head is R^T exp(-w) = exp(-R^T w) R^T of the building.
  const Eigen::Matrix3d c = head_from_building.transpose() * head_covariance * head_from_building;
  rotation.covariance = 0.5 * (c + c.transpose());
  return rotation;
}

}  // namespace

std::optional<double> HeadingOf(const OrientationFrame& frame) {
  if (!frame.rotation) return std::nullopt;
  const Eigen::Vector3d ahead = frame.rotation->building_from_head * Eigen::Vector3d::UnitZ();
  return std::atan2(ahead.y(), ahead.x());
}

AxesFollower::AxesFollower(const FollowOptions& options,
                           const TraversabilityOptions& traversability,
                           const ManhattanOptions& manhattan)
    : options_(options), traversability_(traversability), manhattan_(manhattan) {}

std::optional<AxesFollower::Known> AxesFollower::Predict(const OrientationViewPtr& view) const {
  const RelativePose pose = FindRelativePose(
      MatchBearings(last_->view->features, view->features, traversability_.matching),
      traversability_.relative);
  if (!pose.accepted()) return std::nullopt;
  return Known{
      .view = view,
      .head_from_building = pose.b_from_a * last_->head_from_building,
      .covariance = pose.covariance + pose.b_from_a * last_->covariance * pose.b_from_a.transpose(),
      .reliable = false};
}

FollowedFrame AxesFollower::Settle(const OrientationViewPtr& view, const ManhattanFrame& axes) {
  last_ = Known{.view = view,
                .head_from_building = axes.head_from_axes,
                .covariance = axes.covariance,
                .reliable = true};
  since_last_ = 0;
  return {
      .rotation = RotationOf(axes.head_from_axes, axes.covariance), .reliable = true, .axes = axes};
}

FollowedFrame AxesFollower::Carry(const OrientationViewPtr& view, std::optional<Known> predicted) {
  FollowedFrame followed;
  if (!predicted && since_last_ % options_.carry_frames == 0) predicted = Predict(view);
  followed.axes = Renumbered(view->frame,
                             predicted ? predicted->head_from_building : last_->head_from_building);
  if (!predicted) return followed;
  followed.rotation = RotationOf(predicted->head_from_building, predicted->covariance);
  if (since_last_ >= options_.carry_frames) {
    last_ = std::move(predicted);
    since_last_ = 0;
  }
  return followed;
}

// The features go on from the prediction, not from the chosen frame: lines that were taken up by
// the prediction's own error would feed it.
FollowedFrame AxesFollower::Choose(const OrientationViewPtr& view, Known predicted) {
  const ManhattanFrame axes =
      FindManhattanFrameNear(view->lines, predicted.head_from_building, manhattan_);
  const double drift = RotationAngle(axes.head_from_axes, predicted.head_from_building);
  FollowedFrame followed = Carry(view, std::move(predicted));
  if (!axes.reliable() || drift > options_.max_rival_drift_rad) return followed;
  followed.rotation = RotationOf(axes.head_from_axes, axes.covariance);
  followed.reliable = true;
  followed.axes = axes;
  return followed;
}

FollowedFrame AxesFollower::Follow(const OrientationViewPtr& view) {
  if (!last_) {
    const ManhattanFrame axes = Renumbered(view->frame, LookingAlongX());
    if (!view->frame.reliable()) return {.rotation = {}, .reliable = false, .axes = axes};
    return Settle(view, axes);
  }
  ++since_last_;
  const bool rival = view->frame.trouble == FrameTrouble::kRival;
  if (!view->frame.reliable() && !rival) return Carry(view, std::nullopt);
  const ManhattanFrame nearest = Renumbered(view->frame, last_->head_from_building);
  const double turned = RotationAngle(nearest.head_from_axes, last_->head_from_building);
  const bool steady = last_->reliable && since_last_ == 1 && turned <= options_.max_jump_rad;
  if (steady && !rival) return Settle(view, nearest);
  std::optional<Known> predicted = Predict(view);
  // Without a common view the axes are all there is to go by.
  if (!predicted) return rival ? Carry(view, std::nullopt) : Settle(view, nearest);
  if (rival) return Choose(view, std::move(*predicted));
  const ManhattanFrame axes = Renumbered(view->frame, predicted->head_from_building);
  const double drift = RotationAngle(axes.head_from_axes, predicted->head_from_building);
  if (drift <= options_.max_drift_rad) return Settle(view, axes);
  return Carry(view, std::move(predicted));
}

}  // namespace waystone
