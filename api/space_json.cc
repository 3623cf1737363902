// SPDX-License-Identifier: Apache-2.0
#include "api/space_json.h"

#include "api/map_json.h"
#include "core/camera/image_plane.h"
#include "localizer/planes/keyframe_space.h"

namespace waystone {
namespace {

// An outline's points beyond this many times the plane's distance are left out: they are seen at so
// flat an angle that their position is meaningless.
constexpr double kFarthest = 20;

Json PointJson(const Eigen::Vector3d& x) {
  constexpr int kDecimals = 4;
  return {Rounded(x.x(), kDecimals), Rounded(x.y(), kDecimals), Rounded(x.z(), kDecimals)};
}

Json OutlineJson(const Keyframe& keyframe, const Camera& camera, const PlaneInView& seen,
                 const PlaneInSpace& plane) {
  Json outline = Json::array();
  for (const Eigen::Vector2d& px : OutlineIn(keyframe, *seen.plane, *seen.view)) {
    const auto x = OnImagePlane(camera, px);
    if (!x) continue;
    const Eigen::Vector3d ray = x->homogeneous();
    const double slope = plane.normal.dot(ray);
    if (slope * kFarthest < ray.norm()) continue;
    outline.push_back(PointJson(plane.distance / slope * ray));
  }
  return outline;
}

Json PlaneJson(const Keyframe& keyframe, const Camera& camera, const PlaneInView& seen,
               const PlaneInSpace& plane) {
  const bool sure = plane.error == SpaceError::kNone;
  Json json;
  json["id"] = seen.plane->id.value;
  json["trouble"] = sure ? Json(nullptr) : Json(NameOf(plane.error));
  json["normal"] = sure ? PointJson(plane.normal) : Json(nullptr);
  json["distance"] = sure ? Json(Rounded(plane.distance, 4)) : Json(nullptr);
  json["normal_deviation_rad"] = sure ? Json(Rounded(plane.normal_sigma_rad, 5)) : Json(nullptr);
  json["distance_deviation"] =
      sure ? Json(Rounded(plane.distance_sigma * plane.distance, 5)) : Json(nullptr);
  json["outline"] = sure ? OutlineJson(keyframe, camera, seen, plane) : Json::array();
  return json;
}

Json CornersJson(const Keyframe& keyframe, const Camera& camera) {
  Json corners = Json::array();
  const double right = keyframe.width - 1;
  const double bottom = keyframe.height - 1;
  for (const Eigen::Vector2d& px :
       {Eigen::Vector2d(0, 0), {right, 0}, {right, bottom}, {0, bottom}}) {
    const auto x = OnImagePlane(camera, px);
    corners.push_back(PointJson(x ? x->homogeneous() : Eigen::Vector3d(0, 0, 1)));
  }
  return corners;
}

}  // namespace

Json SpaceJson(const MapIndex& index, const Keyframe& keyframe) {
  const KeyframeSpace space = EstimateSpace(index, keyframe);
  const int unit = space.estimate.unit_plane;
  Json json;
  json["keyframe"] = keyframe.id.value;
  json["views"] = space.views;
  json["unit_plane"] = unit < 0 ? Json(nullptr) : Json(space.planes[unit].plane->id.value);
  json["image_from_camera"] = ToJson(ImageFromCamera(space.camera));
  json["corners"] = CornersJson(keyframe, space.camera);
  json["planes"] = Json::array();
  for (size_t p = 0; p < space.planes.size(); ++p) {
    json["planes"].push_back(
        PlaneJson(keyframe, space.camera, space.planes[p], space.estimate.planes[p]));
  }
  return json;
}

}  // namespace waystone
