// SPDX-License-Identifier: Apache-2.0
#include "quality/pose_error.h"

#include <cmath>
#include <vector>

#include "core/geometry/angle.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

// The camera's motion from a pose relative to a node: x ahead of its camera, y to its left, seen
// from above. A turn to the left is one about the camera's -y axis, which points up.
Eigen::Isometry3d CameraMotion(const Pose2& node_from_query, double metres_per_unit) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.translation() =
      metres_per_unit * Eigen::Vector3d(-node_from_query.y, 0, node_from_query.x);
  motion.linear() =
      Eigen::AngleAxisd(-node_from_query.theta_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return motion;
}

// The query's pose in the frame of the answered image, as far as the answer gives it.
Eigen::Isometry3d ComputeMotion(const Answer& answer,
                                const std::optional<double>& metres_per_unit) {
  if (!answer.panorama) {
    return CameraMotion({0, 0, answer.heading ? answer.heading->rad : 0}, 0);
  }
  const Pose2& node = answer.panorama->node.pose;
  const Pose2& query = answer.panorama->pose;
  const double dx = query.x - node.x;
  const double dy = query.y - node.y;
  const double c = std::cos(node.theta_rad);
  const double s = std::sin(node.theta_rad);
  return CameraMotion(
      {c * dx + s * dy, c * dy - s * dx, WrappedAngle(query.theta_rad - node.theta_rad)},
      metres_per_unit.value_or(0));
}

// The same by the answer's pose; nothing where the answer or the image of its place has none.
std::optional<Eigen::Isometry3d> ComputePosedMotion(const Answer& answer,
                                                    const AnsweredPlace& place,
                                                    const std::optional<PoseLayer>& layer) {
  if (!layer || !answer.pose) return std::nullopt;
  const CameraPose* pose = nullptr;
  if (place.layer == PlaceLayer::kPlanes) {
    pose = layer->Find(KeyframeId{place.id});
  } else {
    pose = layer->Find(AppearanceNodeId{place.id});
  }
  if (!pose) return std::nullopt;
  return pose->frame_from_camera().inverse() * answer.pose->frame_from_camera;
}

bool HasHeading(const Answer& answer) {
  return answer.heading && answer.heading->frame != HeadingFrame::kBuilding;
}

}  // namespace

std::optional<double> MetresPerUnit(const MapData& map, const PlacePoses& poses) {
  if (!map.appearance) return std::nullopt;
  if (map.appearance->metres_per_unit) return map.appearance->metres_per_unit;
  std::vector<double> scales;
  const std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  for (size_t i = 1; i < nodes.size(); ++i) {
    const auto a = poses.find(PlaceIdOf(nodes[i - 1].id));
    const auto b = poses.find(PlaceIdOf(nodes[i].id));
    if (a == poses.end() || b == poses.end() || nodes[i].sequence != nodes[i - 1].sequence)
      continue;
    const double units =
        std::hypot(nodes[i].pose.x - nodes[i - 1].pose.x, nodes[i].pose.y - nodes[i - 1].pose.y);
    const double metres =
        (a->second.world_from_camera.translation() - b->second.world_from_camera.translation())
            .norm();
    if (units > 0) scales.push_back(metres / units);
  }
  if (scales.empty()) return std::nullopt;
  return Median(std::move(scales));
}

std::optional<PoseError> ComparePose(const Answer& answer, const PlacePoses& poses,
                                     const std::optional<double>& metres_per_unit,
                                     const TruePose& truth, const std::optional<PoseLayer>& layer) {
  const std::optional<AnsweredPlace> place = PlaceOf(answer);
  if (!place) return std::nullopt;
  const auto at = poses.find({place->layer, place->id});
  if (at == poses.end()) return std::nullopt;
  const TruePose& image = at->second;
  const auto posed = ComputePosedMotion(answer, *place, layer);
  Eigen::Isometry3d motion = posed ? *posed : ComputeMotion(answer, metres_per_unit);
  if (!image.has_rotation) motion.translation().setZero();  // not known in which direction
  const Eigen::Isometry3d estimate = image.world_from_camera * motion;
  PoseError error;
  error.metres = (estimate.translation() - truth.world_from_camera.translation()).norm();
  if (image.has_rotation && truth.has_rotation && (posed || HasHeading(answer))) {
    const Eigen::Quaterniond a(estimate.linear());
    error.rad = a.angularDistance(Eigen::Quaterniond(truth.world_from_camera.linear()));
  }
  return error;
}

PlacePoses PosesOfLayer(const MapData& map) {
  PlacePoses poses;
  if (!map.poses) return poses;
  for (const KeyframePose& pose : map.poses->keyframes) {
    poses[PlaceIdOf(pose.keyframe)] = {pose.frame_from_camera(), true};
  }
  for (const NodePose& pose : map.poses->nodes) {
    poses[PlaceIdOf(pose.node)] = {pose.frame_from_camera(), true};
  }
  return poses;
}

}  // namespace waystone
