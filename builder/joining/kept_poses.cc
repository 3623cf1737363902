// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/kept_poses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "builder/poses/plane_fit.h"
#include "core/camera/camera.h"
#include "schema/layers/planes/keyframe_camera.h"

namespace waystone {
namespace {

using Eigen::Vector3d;

std::pair<float, float> PositionKey(const PlaneFeature& feature) {
  return {feature.reference.x_px, feature.reference.y_px};
}

// The camera of a keyframe with a pose.
struct PosedCamera {
  Eigen::Isometry3d frame_from_camera;
  Camera camera;
};

std::optional<PosedCamera> CameraOf(const MapData& map, KeyframeId id) {
  const KeyframePose* pose = map.poses->Find(id);
  std::optional<Camera> camera = CameraOfKeyframe(map, id);
  if (pose == nullptr || !camera) return std::nullopt;
  return PosedCamera{pose->frame_from_camera(), std::move(*camera)};
}

// Where the ray of a pixel meets the plane. How much the surface differs from the plane isn't
// stored, so the depth's error is only that of the fit.
DepthCode DepthOnPlane(const PosedCamera& posed, const PlanePose& plane, const Keypoint& keypoint) {
  const Vector3d ray = Unproject(posed.camera, PositionOf(keypoint)).normalized();
  const FittedPlane fit{plane.normal, plane.distance, plane.covariance, 0, 0};
  const auto met = MeetPlane(posed.frame_from_camera, ray, fit);
  return met && std::isfinite(met->sigma) ? EncodeDepth(met->depth, met->sigma) : DepthCode{};
}

template <class Item, class Id, class Has>
void KeepThose(std::vector<Item>& items, Id Item::*id, const Has& has) {
  std::erase_if(items, [&](const Item& item) { return !has.contains(item.*id); });
}

}  // namespace

PosesBefore::PosesBefore(const MapData& map) {
  if (!map.poses) return;
  for (const Plane& plane : map.planes) {
    const auto known =
        std::ranges::lower_bound(map.poses->plane_depths, plane.id, {}, &PlaneDepths::plane);
    if (known == map.poses->plane_depths.end() || known->plane != plane.id) continue;
    PlaneBefore& before = planes_[plane.id];
    before.reference = plane.reference;
    for (size_t f = 0; f < plane.features.size(); ++f) {
      before.depths.emplace(PositionKey(plane.features[f]), known->features[f]);
    }
  }
}

void PosesBefore::KeepPoses(MapData& map) const {
  if (!map.poses) return;
  PoseLayer& layer = *map.poses;
  std::set<KeyframeId> keyframes;
  for (const Keyframe& keyframe : map.keyframes) keyframes.insert(keyframe.id);
  std::set<PlaneId> planes;
  for (const Plane& plane : map.planes) planes.insert(plane.id);
  KeepThose(layer.keyframes, &KeyframePose::keyframe, keyframes);
  KeepThose(layer.landmark_depths, &LandmarkDepths::keyframe, keyframes);
  KeepThose(layer.planes, &PlanePose::plane, planes);
  if (layer.keyframes.empty() && layer.nodes.empty()) {
    map.poses.reset();
    return;
  }
  layer.plane_depths.clear();
  for (const Plane& plane : map.planes) {
    const std::optional<PosedCamera> posed = CameraOf(map, plane.reference);
    if (!posed) continue;
    const auto fitted = std::ranges::lower_bound(layer.planes, plane.id, {}, &PlanePose::plane);
    const bool has_fit = fitted != layer.planes.end() && fitted->plane == plane.id;
    if (has_fit) TurnAway(posed->frame_from_camera, fitted->normal, fitted->distance);
    const auto before = planes_.find(plane.id);
    const bool as_before = before != planes_.end() && before->second.reference == plane.reference;
    PlaneDepths depths{plane.id, {}};
    for (const PlaneFeature& feature : plane.features) {
      const DepthCode* known = nullptr;
      if (as_before) {
        const auto found = before->second.depths.find(PositionKey(feature));
        if (found != before->second.depths.end()) known = &found->second;
      }
      depths.features.push_back(known     ? *known
                                : has_fit ? DepthOnPlane(*posed, *fitted, feature.reference)
                                          : DepthCode{});
    }
    layer.plane_depths.push_back(std::move(depths));
  }
}

}  // namespace waystone
