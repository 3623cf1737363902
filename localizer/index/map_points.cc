// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/map_points.h"

#include <algorithm>
#include <optional>

#include "schema/layers/planes/keyframe_camera.h"

namespace waystone {
namespace {

// The ray of a pixel of a posed keyframe.
class PosedRays {
 public:
  PosedRays(const MapData& map, KeyframeId id)
      : pose_(map.poses->Find(id)), camera_(CameraOfKeyframe(map, id)) {}

  MapPoint PointAt(const Eigen::Vector2d& pixel, const DepthCode& code) const {
    if (!pose_ || !camera_ || !code.known()) return {};
    const double depth = DepthOf(code);
    const Eigen::Vector3d direction = pose_->rotation * Unproject(*camera_, pixel);
    const Eigen::Vector3d x = pose_->position + depth * direction;
    return {x.cast<float>(), (depth * RelativeSigmaOf(code) * direction).cast<float>(),
            static_cast<float>(depth)};
  }

 private:
  const KeyframePose* pose_ = nullptr;
  std::optional<Camera> camera_;
};

}  // namespace

std::vector<MapPoint> LocateMapPoints(const MapData& map) {
  std::vector<MapPoint> points;
  if (!map.poses) return points;
  const PoseLayer& layer = *map.poses;
  for (const Plane& plane : map.planes) {
    const size_t first = points.size();
    points.resize(first + plane.features.size());
    const auto depths =
        std::ranges::lower_bound(layer.plane_depths, plane.id, {}, &PlaneDepths::plane);
    if (depths == layer.plane_depths.end() || depths->plane != plane.id) continue;
    const PosedRays rays(map, plane.reference);
    for (size_t f = 0; f < std::min(plane.features.size(), depths->features.size()); ++f) {
      points[first + f] =
          rays.PointAt(PositionOf(plane.features[f].reference), depths->features[f]);
    }
  }
  for (const Keyframe& keyframe : map.keyframes) {
    const size_t first = points.size();
    points.resize(first + keyframe.landmarks.size());
    const auto depths =
        std::ranges::lower_bound(layer.landmark_depths, keyframe.id, {}, &LandmarkDepths::keyframe);
    if (depths == layer.landmark_depths.end() || depths->keyframe != keyframe.id) continue;
    const PosedRays rays(map, keyframe.id);
    const std::vector<ImagePosition>& positions = keyframe.landmarks.positions;
    for (size_t i = 0; i < std::min(positions.size(), depths->landmarks.size()); ++i) {
      points[first + i] = rays.PointAt(
          DecodePosition(positions[i], keyframe.width, keyframe.height), depths->landmarks[i]);
    }
  }
  return points;
}

}  // namespace waystone
