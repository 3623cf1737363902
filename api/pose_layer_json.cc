// SPDX-License-Identifier: Apache-2.0
#include "api/pose_layer_json.h"

#include <optional>

#include "core/base/error.h"
#include "core/camera/camera.h"
#include "schema/layers/planes/keyframe_camera.h"
#include "schema/layers/poses/horizontal.h"

namespace waystone {
namespace {

constexpr int kPoseDecimals = 6;

Json DirectionOrPointJson(const Eigen::Vector3d& x) {
  return {Rounded(x.x(), kPoseDecimals), Rounded(x.y(), kPoseDecimals),
          Rounded(x.z(), kPoseDecimals)};
}

Json QuaternionJson(const Eigen::Quaterniond& q) {
  return {Rounded(q.x(), kPoseDecimals), Rounded(q.y(), kPoseDecimals),
          Rounded(q.z(), kPoseDecimals), Rounded(q.w(), kPoseDecimals)};
}

// 0 is stored where none was measured.
Json DeviationJson(double sigma) { return sigma > 0 ? Json(sigma) : Json(nullptr); }

// In columns.
template <class Pose, class Id>
Json CameraPosesJson(const std::vector<Pose>& poses, Id Pose::*id) {
  Json json = {{"id", Json::array()}, {"position", Json::array()}, {"orientation", Json::array()}};
  for (const Pose& pose : poses) {
    json["id"].push_back((pose.*id).value);
    json["position"].push_back(DirectionOrPointJson(pose.position));
    json["orientation"].push_back(QuaternionJson(pose.rotation));
  }
  return json;
}

// Where the rays of the outline's pixels meet the plane.
Json PosedOutlineJson(const MapIndex& index, const PoseLayer& layer, const Plane& plane,
                      const PlanePose& placed) {
  // Smallest sine of the angle between a ray and the plane: below it, one pixel moves the point so
  // far that its position is meaningless.
  constexpr double kLeastSine = 0.05;
  Json outline = Json::array();
  const KeyframePose* pose = layer.Find(plane.reference);
  const std::optional<Camera> camera = CameraOfKeyframe(index.map(), plane.reference);
  if (!pose || !camera) return outline;
  const double ahead = placed.distance - placed.normal.dot(pose->position);
  for (const Eigen::Vector2d& px : plane.outline) {
    const Eigen::Vector3d ray = pose->rotation * Unproject(*camera, px);
    const double sine = placed.normal.dot(ray);
    if (sine < kLeastSine || ahead <= 0) continue;
    outline.push_back(DirectionOrPointJson(pose->position + ahead / sine * ray));
  }
  return outline;
}

Json PosedPlaneJson(const MapIndex& index, const PoseLayer& layer, const Plane& plane,
                    const PlanePose& placed) {
  Json json;
  json["id"] = plane.id.value;
  json["reference"] = plane.reference.value;
  json["normal"] = DirectionOrPointJson(placed.normal);
  json["distance"] = Rounded(placed.distance, kPoseDecimals);
  json["outline"] = PosedOutlineJson(index, layer, plane, placed);
  return json;
}

}  // namespace

const PoseLayer& PosesOf(const MapIndex& index) {
  if (index.map().poses) return *index.map().poses;
  throw MapError(ErrorCode::kNoLayer,
                 "this map has no poses; build it from the images of a calibrated camera or from "
                 "panoramas with --poses FILE");
}

Json PoseLayerJson(const MapIndex& index, const PoseLayer& layer) {
  const std::optional<Eigen::Vector3d> up = EstimateUp(layer);
  Json json;
  json["frame"] = layer.frame;
  json["unit"] = NameOf(layer.unit);
  json["noise"] = {{"position_deviation", DeviationJson(layer.noise.position_sigma)},
                   {"rotation_deviation_rad", DeviationJson(layer.noise.rotation_sigma_rad)}};
  json["up"] = up ? DirectionOrPointJson(*up) : Json(nullptr);
  json["keyframes"] = CameraPosesJson(layer.keyframes, &KeyframePose::keyframe);
  json["nodes"] = CameraPosesJson(layer.nodes, &NodePose::node);
  json["planes"] = Json::array();
  for (const PlanePose& placed : layer.planes) {
    const Plane* plane = index.FindPlane(placed.plane);
    if (plane) json["planes"].push_back(PosedPlaneJson(index, layer, *plane, placed));
  }
  return json;
}

}  // namespace waystone
