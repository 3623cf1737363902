// SPDX-License-Identifier: Apache-2.0
#include "localizer/poses/node_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "localizer/index/node_distances.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using LevelAxes = Eigen::Matrix<double, 3, 2>;

// Distances to nodes are at least this, for stability.
constexpr double kLeastSpacings = 0.05;

LevelAxes LevelAxesOf(const Horizontal& horizontal) {
  LevelAxes axes;
  axes << horizontal.right, horizontal.top;
  return axes;
}

// The mean height of the considered nodes, with nearer and better verified ones weighted more.
double HeightOf(const MapIndex& index, const PanoramaAnswer& panorama, const NodePose& nearest) {
  const Horizontal& horizontal = *index.horizontal();
  const double spacing = std::max(index.appearance().spacing(), 1e-9);
  const Vector2d at(panorama.pose.x, panorama.pose.y);
  double sum = 0;
  double weights = 0;
  const auto add = [&](const NodePose& node, int inliers) {
    const double distance =
        std::max((horizontal.Of(node.position) - at).norm(), kLeastSpacings * spacing);
    const double weight = (1 + inliers) / (distance * distance);
    sum += weight * horizontal.up.dot(node.position);
    weights += weight;
  };
  add(nearest, 0);
  for (const NodeCandidate& candidate : panorama.candidates) {
    const NodePose* node = index.map().poses->Find(candidate.node.id);
    if (!node) continue;
    const double apart = (node->position - nearest.position).norm();
    if (apart <= kSameFloorSpacings * spacing) add(*node, candidate.inliers);
  }
  return sum / weights;
}

// Relative to the best node, from which the answer's heading comes, or else to the nearest.
Matrix3d RotationOf(const MapIndex& index, const Answer& answer, const NodePose& nearest) {
  const PanoramaAnswer& panorama = *answer.panorama;
  const bool in_series = answer.decided_by == DecidedBy::kSeries;
  const NodeCandidate& best = panorama.candidates.front();
  const NodePose* of_best = in_series ? nullptr : index.map().poses->Find(best.node.id);
  if (of_best && best.query_from_node) {
    return of_best->rotation.toRotationMatrix() * best.query_from_node->transpose();
  }
  const NodePose& node = of_best ? *of_best : nearest;
  const double turned = panorama.pose.theta_rad - index.horizontal()->Of(node).theta_rad;
  return Eigen::AngleAxisd(turned, index.horizontal()->up) * node.rotation.toRotationMatrix();
}

Eigen::Matrix<double, 6, 6> CovarianceOf(const MapIndex& index, const Answer& answer,
                                         const NodePoseErrors& errors) {
  const Vector3d& up = index.horizontal()->up;
  const LevelAxes level = LevelAxesOf(*index.horizontal());
  const double heading2 =
      std::pow(answer.heading->sigma_rad, 2) + std::pow(errors.heading_sigma_rad, 2);
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance.topLeftCorner<3, 3>() = std::pow(errors.position_factor, 2) * level *
                                         answer.panorama->covariance * level.transpose() +
                                     std::pow(errors.height_sigma, 2) * up * up.transpose();
  covariance.bottomRightCorner<3, 3>() =
      std::pow(errors.tilt_sigma_rad, 2) * level * level.transpose() +
      heading2 * up * up.transpose();
  return covariance;
}

}  // namespace

bool IsVerified(const PanoramaAnswer& panorama) {
  return !panorama.candidates.empty() && panorama.candidates.front().inliers > 0;
}

NodePoseErrors DefaultNodePoseErrors(double spacing, bool verified) {
  constexpr double kHeightSpacings = 0.1;
  return {.position_factor = 1,
          .height_sigma = kHeightSpacings * spacing,
          .heading_sigma_rad = verified ? 0.02 : 0.2,
          .tilt_sigma_rad = 0.03};
}

std::optional<QueryPose> EstimateNodePose(const MapIndex& index, const Answer& answer,
                                          const NodePoseErrors& errors) {
  const std::optional<PoseLayer>& layer = index.map().poses;
  WS_CHECK(layer.has_value(), "the map has no pose layer");
  if (!answer.panorama || answer.panorama->candidates.empty() || !answer.heading) {
    return std::nullopt;
  }
  const PanoramaAnswer& panorama = *answer.panorama;
  const NodePose* nearest = layer->Find(panorama.node.id);
  if (!nearest) return std::nullopt;
  const Horizontal& horizontal = *index.horizontal();
  Isometry3d frame_from_camera = Isometry3d::Identity();
  frame_from_camera.linear() = RotationOf(index, answer, *nearest);
  frame_from_camera.translation() =
      LevelAxesOf(horizontal) * Vector2d(panorama.pose.x, panorama.pose.y) +
      HeightOf(index, panorama, *nearest) * horizontal.up;
  return QueryPose{.frame = layer->frame,
                   .unit = layer->unit,
                   .frame_from_camera = frame_from_camera,
                   .covariance = CovarianceOf(index, answer, errors),
                   .inliers = panorama.candidates.front().inliers,
                   .by_own_camera = false};
}

void AddNodePose(const MapIndex& index, Answer& answer) {
  const std::optional<PoseLayer>& layer = index.map().poses;
  if (!layer) return;
  if (answer.verdict != Verdict::kLocalized) {
    answer.pose_reason = "not localized";
    return;
  }
  if (layer->nodes.empty()) {
    answer.pose_reason = "the map has poses of its photos alone, and a panorama answered";
    return;
  }
  const bool verified = IsVerified(*answer.panorama);
  const auto& measured = verified ? layer->verified_errors : layer->appearance_errors;
  answer.pose = EstimateNodePose(
      index, answer,
      measured.value_or(DefaultNodePoseErrors(index.appearance().spacing(), verified)));
  if (!answer.pose) {
    answer.pose_reason =
        "the nearest panorama, " + answer.panorama->node.source + ", was mapped without a pose";
  }
}

}  // namespace waystone
