// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/follow.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "core/geometry/rotation.h"
#include "core/manhattan/cube_rotations.h"
#include "schema/layers/orientation/orientation_trajectory.h"

namespace waystone {
namespace {

// rig_from_building of a rig that looks along x: x ahead, y to the left, z up.
Eigen::Matrix3d LookingAlongX() {
  Eigen::Matrix3d axes;
  axes.col(0) = Eigen::Vector3d::UnitZ();
  axes.col(1) = -Eigen::Vector3d::UnitX();
  axes.col(2) = -Eigen::Vector3d::UnitY();
  return axes;
}

BuildingRotation MakeBuildingRotation(const Eigen::Matrix3d& rig_from_building,
                                      const Eigen::Matrix3d& rig_covariance) {
  BuildingRotation rotation;
  Eigen::Quaterniond q(Eigen::Matrix3d(rig_from_building.transpose()));
  q.normalize();
  if (q.w() < 0) q.coeffs() *= -1;
  rotation.building_from_rig = q;
  // exp(w) R of the rig is R^T exp(-w) = exp(-R^T w) R^T of the building.
  const Eigen::Matrix3d c = rig_from_building.transpose() * rig_covariance * rig_from_building;
  rotation.covariance = 0.5 * (c + c.transpose());
  return rotation;
}

constexpr double kEighth = 0.25 * std::numbers::pi;  // half a quarter turn
constexpr size_t kMostGuesses = 12;  // frames that are tracked before the axes are settled
constexpr size_t kMostAnchors = 24;

Eigen::Vector3d RotationVector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

// Fuses a measured rotation with a known one by their covariances (Kalman update).
void Join(const Eigen::Matrix3d& measured, const Eigen::Matrix3d& measured_covariance,
          Eigen::Matrix3d& known, Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d gain = covariance * (covariance + measured_covariance).inverse();
  known = RotationByVector(gain * RotationVector(measured * known.transpose())) * known;
  const Eigen::Matrix3d left = (Eigen::Matrix3d::Identity() - gain) * covariance;
  covariance = 0.5 * (left + left.transpose());
}

}  // namespace

std::optional<double> HeadingOf(const OrientationFrame& frame) {
  return frame.rotation ? HeadingOf(*frame.rotation) : std::nullopt;
}

AxesFollower::AxesFollower(const FollowOptions& options,
                           const TraversabilityOptions& traversability,
                           const ManhattanOptions& manhattan)
    : options_(options), traversability_(traversability), manhattan_(manhattan) {}

std::optional<AxesFollower::Known> AxesFollower::Predict(const Known& from,
                                                         const OrientationViewPtr& view) const {
  const RelativePose pose =
      FindRelativePose(MatchBearings(from.view->features, view->features, traversability_.matching),
                       traversability_.relative);
  if (!pose.accepted() && !pose.one_of_two()) return std::nullopt;
  const int frames = frame_ - from.frame;
  Eigen::Matrix3d turn = pose.b_from_a;
  double sigma = options_.step_sigma_rad;
  if (pose.one_of_two()) {
    if (frames > options_.steady_frames) return std::nullopt;
    const Eigen::Matrix3d expected = RotationByVector(from.rate * frames);
    const double off = RotationAngle(pose.b_from_a, expected);
    const double rival_off = RotationAngle(pose.rival->b_from_a, expected);
    if (rival_off < off) turn = pose.rival->b_from_a;
    const double apart = RotationAngle(pose.b_from_a, pose.rival->b_from_a);
    const bool clear = std::min(off, rival_off) <= options_.clear_share * std::max(off, rival_off);
    // If either may be meant, it does no harm as long as they hardly differ.
    if (!clear && apart > options_.max_rival_drift_rad) return std::nullopt;
    sigma = std::max(sigma, (clear ? options_.doubt_share : options_.clear_share) * apart);
  }
  return Known{.view = view,
               .frame = frame_,
               .rig_from_building = turn * from.rig_from_building,
               .covariance = pose.covariance + turn * from.covariance * turn.transpose() +
                             sigma * sigma * Eigen::Matrix3d::Identity(),
               .votes = from.votes,
               .rate = RotationVector(turn) / frames};
}

std::optional<ManhattanFrame> AxesFollower::AxesNear(const OrientationViewPtr& view,
                                                     const Known& predicted) const {
  const auto drift = [&](const ManhattanFrame& axes) {
    return RotationAngle(axes.rig_from_axes, predicted.rig_from_building);
  };
  if (view->frame.reliable()) {
    ManhattanFrame own = Renumbered(view->frame, predicted.rig_from_building);
    if (drift(own) <= options_.max_drift_rad) return own;
  }
  // A doubtful prediction would find lines near it anyway.
  if (WorstAxisSigma(predicted.covariance) > options_.clear_share * options_.max_rival_drift_rad)
    return std::nullopt;
  ManhattanFrame near =
      FindManhattanFrameNear(view->lines, predicted.rig_from_building, manhattan_);
  if (!near.reliable() || drift(near) > options_.max_rival_drift_rad) return std::nullopt;
  return near;
}

void AxesFollower::AddAnchor(const Known& known) {
  if (anchors_.size() >= kMostAnchors) anchors_.erase(anchors_.begin());
  anchors_.push_back(known);
}

FollowedFrame AxesFollower::Know(Known known, ManhattanFrame axes, bool reliable) {
  FollowedFrame followed;
  followed.rotation = MakeBuildingRotation(known.rig_from_building, known.covariance);
  followed.anchored = anchored_;
  followed.reliable = reliable && anchored_;
  followed.axes = std::move(axes);
  const bool due = anchors_.empty() || frame_ - anchors_.back().frame >= options_.anchor_frames;
  if (followed.reliable && due) AddAnchor(known);
  last_ = std::move(known);
  return followed;
}

// A prediction, fused with the lines' axes where these are near it.
FollowedFrame AxesFollower::Carry(Known predicted) {
  const std::optional<ManhattanFrame> axes = AxesNear(predicted.view, predicted);
  if (!axes) {
    ManhattanFrame none = Renumbered(predicted.view->frame, predicted.rig_from_building);
    return Know(std::move(predicted), std::move(none), false);
  }
  Join(axes->rig_from_axes, axes->covariance, predicted.rig_from_building, predicted.covariance);
  return Know(std::move(predicted), *axes, true);
}

// Before the axes are settled: carries the frames from the views so far over to this one. A frame
// on which enough views agree, or that has no rival, settles the axes.
FollowedFrame AxesFollower::Settle(const OrientationViewPtr& view) {
  std::vector<Known> guesses;
  for (const Known& guess : guesses_) {
    if (auto carried = Predict(guess, view)) guesses.push_back(std::move(*carried));
  }
  FollowedFrame followed;
  followed.axes = Renumbered(view->frame, LookingAlongX());
  const bool told = view->frame.reliable() || view->frame.error == FrameError::kRival;
  if (told) {
    const auto same = std::ranges::find_if(guesses, [&](const Known& guess) {
      return CubeAngle(view->frame.rig_from_axes, guess.rig_from_building) <=
             options_.max_rival_drift_rad;
    });
    if (same == guesses.end()) {
      guesses.push_back({.view = view,
                         .frame = frame_,
                         .rig_from_building = followed.axes.rig_from_axes,
                         .covariance = view->frame.covariance});
    } else {
      ++same->votes;
      Join(Renumbered(view->frame, same->rig_from_building).rig_from_axes, view->frame.covariance,
           same->rig_from_building, same->covariance);
    }
  }
  std::ranges::stable_sort(guesses, std::greater<>(), &Known::votes);
  guesses.resize(std::min(guesses.size(), kMostGuesses));
  guesses_ = std::move(guesses);
  const bool clear = view->frame.reliable() && view->frame.rival <= options_.max_clear_rival;
  if (clear) {
    return Know({.view = view,
                 .frame = frame_,
                 .rig_from_building = followed.axes.rig_from_axes,
                 .covariance = view->frame.covariance},
                followed.axes, true);
  }
  if (guesses_.empty() || guesses_.front().votes < options_.min_votes) return followed;
  if (guesses_.size() > 1 && guesses_[1].votes > options_.clear_share * guesses_.front().votes)
    return followed;
  Known best = guesses_.front();
  best.rig_from_building = NearestOfCube(best.rig_from_building, LookingAlongX());
  return Carry(std::move(best));
}

// The rotation of a view by any frame whose quarter turn is known.
std::optional<AxesFollower::Known> AxesFollower::Anchored(const OrientationViewPtr& view) const {
  for (auto anchor = anchors_.rbegin(); anchor != anchors_.rend(); ++anchor) {
    if (auto known = Predict(*anchor, view)) return known;
  }
  return std::nullopt;
}

// Handles a frame that nothing connects to the one before it.
FollowedFrame AxesFollower::TakeUp(const OrientationViewPtr& view) {
  FollowedFrame followed;
  followed.axes = Renumbered(view->frame, last_->rig_from_building);
  if (!view->frame.reliable()) return followed;
  // The rig can have turned by less than half a quarter turn.
  const bool short_gap = (frame_ - last_->frame) * options_.max_jump_rad < kEighth;
  if (!short_gap && anchored_) {
    AddAnchor(*last_);
    anchored_ = false;
  }
  const double turned = RotationAngle(followed.axes.rig_from_axes, last_->rig_from_building);
  if (short_gap && turned > options_.max_jump_rad * (frame_ - last_->frame)) return followed;
  return Know({.view = view,
               .frame = frame_,
               .rig_from_building = followed.axes.rig_from_axes,
               .covariance = view->frame.covariance},
              followed.axes, true);
}

FollowedFrame AxesFollower::Follow(const OrientationViewPtr& view) {
  ++frame_;
  if (!last_) return Settle(view);
  const bool clear = view->frame.reliable() && view->frame.rival <= options_.max_clear_rival;
  const bool doubtful =
      WorstAxisSigma(last_->covariance) > options_.clear_share * options_.max_rival_drift_rad;
  if ((!anchored_ || doubtful) && frame_ % options_.retry_frames == 0) {
    if (auto known = Anchored(view)) {
      anchored_ = true;
      return Carry(std::move(*known));
    }
  }
  if (clear && frame_ - last_->frame == 1) {
    const ManhattanFrame nearest = Renumbered(view->frame, last_->rig_from_building);
    const Eigen::Matrix3d turn = nearest.rig_from_axes * last_->rig_from_building.transpose();
    const Eigen::Vector3d by = RotationVector(turn);
    if (by.norm() <= options_.max_jump_rad && (by - last_->rate).norm() <= options_.max_drift_rad) {
      return Know({.view = view,
                   .frame = frame_,
                   .rig_from_building = nearest.rig_from_axes,
                   .covariance = nearest.covariance,
                   .rate = by},
                  nearest, true);
    }
  }
  if (auto predicted = Predict(*last_, view)) return Carry(std::move(*predicted));
  return TakeUp(view);
}

}  // namespace waystone
