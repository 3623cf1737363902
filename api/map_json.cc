// SPDX-License-Identifier: Apache-2.0
#include "api/map_json.h"

#include <Eigen/Dense>
#include <utility>

#include "api/history_json.h"
#include "core/base/text.h"
#include "core/features/features.h"
#include "localizer/planes/outline.h"

namespace waystone {
namespace {

std::string SequenceName(const MapIndex& index, SequenceId id) {
  for (const Sequence& sequence : index.map().sequences) {
    if (sequence.id == id) return sequence.name;
  }
  return "";
}

Json SequenceJson(const Sequence& sequence) {
  Json json;
  json["id"] = sequence.id.value;
  json["name"] = sequence.name;
  json["kind"] = sequence.kind;
  json["frames"] = sequence.frames;
  json["skipped"] = sequence.skipped;
  json["camera"] = nullptr;
  if (sequence.camera) {
    json["camera"] = {{"model", NameOf(sequence.camera->model)},
                      {"width", sequence.camera->width},
                      {"height", sequence.camera->height},
                      {"params", sequence.camera->params}};
  }
  return json;
}

Json ReferenceJson(const MapIndex& index, KeyframeId id) {
  Json json;
  json["id"] = id.value;
  const Keyframe* keyframe = index.FindKeyframe(id);
  json["source"] = keyframe ? Json(keyframe->source) : Json(nullptr);
  return json;
}

Json SeenPlaneJson(const MapIndex& index, const Keyframe& keyframe, const Plane& plane,
                   const PlaneView& view) {
  Json json;
  json["id"] = plane.id.value;
  json["surface"] = index.SurfaceOf(plane.id).value;
  json["inliers"] = view.inliers;
  json["reference_from_keyframe"] = ToJson(view.reference_from_keyframe);
  json["outline"] = ToJson(OutlineIn(keyframe, plane, view));
  return json;
}

// The planes that a keyframe saw. Walks over all planes, which is fast enough for a single
// keyframe, so the index needn't support it.
Json SeenPlanesJson(const MapIndex& index, const Keyframe& keyframe) {
  Json list = Json::array();
  for (const Plane& plane : index.map().planes) {
    for (const PlaneView& view : plane.views) {
      if (view.keyframe == keyframe.id) {
        list.push_back(SeenPlaneJson(index, keyframe, plane, view));
      }
    }
  }
  return list;
}

Json KeyframeWith(Json planes, const std::string& map_name, const MapIndex& index,
                  const Keyframe& keyframe) {
  Json json;
  json["id"] = keyframe.id.value;
  json["sequence"] = SequenceName(index, keyframe.sequence);
  json["sequence_id"] = keyframe.sequence.value;
  json["source"] = keyframe.source;
  const std::string* place = index.names().OfKeyframe(keyframe.id);
  json["place"] = place ? Json(*place) : Json(nullptr);
  json["time_s"] = OrNull(keyframe.time_s);
  json["stretch"] = keyframe.stretch;
  json["frame"] = keyframe.frame;
  json["width"] = keyframe.width;
  json["height"] = keyframe.height;
  json["image"] = nullptr;
  if (!keyframe.picture.empty()) {
    json["image"] = "/v1/maps/" + EncodeSegment(map_name) + "/keyframes/" +
                    std::to_string(keyframe.id.value) + "/image";
  }
  json["planes"] = std::move(planes);
  json["landmarks"] = keyframe.landmarks.size();
  return json;
}

}  // namespace

std::vector<Eigen::Vector2d> OutlineIn(const Keyframe& keyframe, const Plane& plane,
                                       const PlaneView& view) {
  if (plane.features.empty()) return {};
  const Keypoint& inside = plane.features.front().reference;
  return ClippedOutline(plane.outline, view.reference_from_keyframe.inverse(),
                        {inside.x_px, inside.y_px}, keyframe.width, keyframe.height);
}

Json MapJson(const std::string& name, const MapIndex& index) {
  const MapData& map = index.map();
  size_t features = 0;
  for (const Plane& plane : map.planes) features += plane.features.size();
  Json json;
  json["name"] = name;
  json["version"] = map.info.version;
  json["program"] = map.info.program;
  json["feature_type"] = NameOf(map.info.feature_type);
  json["keyframes"] = map.keyframes.size();
  json["planes"] = map.planes.size();
  json["surfaces"] = index.surface_count();
  json["edges"] = map.edges.size();
  json["features"] = features;
  json["names"] = map.names.size();
  json["floor_plans"] = map.floor_plans.size();
  json["sequences"] = Json::array();
  for (const Sequence& sequence : map.sequences)
    json["sequences"].push_back(SequenceJson(sequence));
  json["sessions"] = SessionsJson(map);
  json["parts"] = PartsJson(map);
  return json;
}

Json PlaneSummaryJson(const MapIndex& index, const Plane& plane) {
  Json json;
  json["id"] = plane.id.value;
  json["surface"] = index.SurfaceOf(plane.id).value;
  json["reference"] = ReferenceJson(index, plane.reference);
  json["features"] = plane.features.size();
  json["views"] = plane.views.size();
  json["neighbours"] = ToJson(index.Neighbours(plane.id));
  json["outline"] = ToJson(plane.outline);
  return json;
}

Json PlaneJson(const MapIndex& index, const Plane& plane) {
  Json json = PlaneSummaryJson(index, plane);
  json["features"] = Json::array();
  for (const PlaneFeature& feature : plane.features)
    json["features"].push_back(FeatureJson(feature));
  json["views"] = Json::array();
  for (const PlaneView& view : plane.views) json["views"].push_back(ViewJson(view));
  return json;
}

Json FeatureJson(const PlaneFeature& feature) {
  Json json;
  json["x_px"] = Rounded(feature.reference.x_px, 2);
  json["y_px"] = Rounded(feature.reference.y_px, 2);
  json["scale_px"] = Rounded(feature.reference.scale_px, 2);
  json["angle_rad"] = Rounded(feature.reference.angle_rad, 4);
  json["votes"] = feature.votes;
  json["visible"] = feature.visible;
  return json;
}

Json ViewJson(const PlaneView& view) {
  Json json;
  json["keyframe"] = view.keyframe.value;
  json["inliers"] = view.inliers;
  json["reference_from_keyframe"] = ToJson(view.reference_from_keyframe);
  return json;
}

Json GraphJson(const MapIndex& index) {
  Json json;
  json["nodes"] = Json::array();
  for (const Plane& plane : index.map().planes) {
    json["nodes"].push_back({{"id", plane.id.value},
                             {"surface", index.SurfaceOf(plane.id).value},
                             {"reference", plane.reference.value},
                             {"features", plane.features.size()}});
  }
  json["edges"] = Json::array();
  for (const Edge& edge : index.map().edges) {
    json["edges"].push_back({{"a", edge.a.value},
                             {"b", edge.b.value},
                             {"from", edge.from.value},
                             {"to", edge.to.value},
                             {"homology", ToJson(edge.homology)},
                             {"third_eigenvalue", edge.third_eigenvalue}});
  }
  return json;
}

Json KeyframeJson(const std::string& map_name, const MapIndex& index, const Keyframe& keyframe) {
  return KeyframeWith(SeenPlanesJson(index, keyframe), map_name, index, keyframe);
}

KeyframeRows::KeyframeRows(std::string map_name, const MapIndex& index)
    : name_(std::move(map_name)), index_(index) {
  for (const Plane& plane : index.map().planes) {
    for (const PlaneView& view : plane.views) seen_[view.keyframe].push_back({&plane, &view});
  }
}

Json KeyframeRows::Row(const Keyframe& keyframe) const {
  Json planes = Json::array();
  if (const auto seen = seen_.find(keyframe.id); seen != seen_.end()) {
    for (const auto& [plane, view] : seen->second) {
      planes.push_back(SeenPlaneJson(index_, keyframe, *plane, *view));
    }
  }
  return KeyframeWith(std::move(planes), name_, index_, keyframe);
}

}  // namespace waystone
