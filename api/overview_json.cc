// SPDX-License-Identifier: Apache-2.0
#include "api/overview_json.h"

#include <unordered_map>

namespace waystone {
namespace {

// What a keyframe saw.
struct Seen {
  int planes = 0;
  int features = 0;
};

std::unordered_map<KeyframeId, Seen> SeenByKeyframe(const MapData& map) {
  std::unordered_map<KeyframeId, Seen> seen;
  for (const Plane& plane : map.planes) {
    for (const PlaneView& view : plane.views) {
      ++seen[view.keyframe].planes;
      seen[view.keyframe].features += view.inliers;
    }
  }
  return seen;
}

Json KeyframesJson(const MapIndex& index) {
  const MapData& map = index.map();
  const std::unordered_map<KeyframeId, Seen> seen = SeenByKeyframe(map);
  Json json = {{"id", Json::array()},    {"sequence", Json::array()}, {"stretch", Json::array()},
               {"frame", Json::array()}, {"planes", Json::array()},   {"features", Json::array()},
               {"place", Json::array()}};
  for (const Keyframe& keyframe : map.keyframes) {
    const auto it = seen.find(keyframe.id);
    const Seen what = it == seen.end() ? Seen{} : it->second;
    json["id"].push_back(keyframe.id.value);
    json["sequence"].push_back(keyframe.sequence.value);
    json["stretch"].push_back(keyframe.stretch);
    json["frame"].push_back(keyframe.frame);
    json["planes"].push_back(what.planes);
    json["features"].push_back(what.features);
    const std::string* place = index.names().OfKeyframe(keyframe.id);
    json["place"].push_back(place ? Json(*place) : Json(nullptr));
  }
  return json;
}

Json PlanesJson(const MapIndex& index) {
  Json json = {{"id", Json::array()},        {"surface", Json::array()},
               {"reference", Json::array()}, {"stretch", Json::array()},
               {"features", Json::array()},  {"keyframes", Json::array()}};
  for (const Plane& plane : index.map().planes) {
    const Keyframe* reference = index.FindKeyframe(plane.reference);
    json["id"].push_back(plane.id.value);
    json["surface"].push_back(index.SurfaceOf(plane.id).value);
    json["reference"].push_back(plane.reference.value);
    json["stretch"].push_back(reference ? Json(reference->stretch) : Json(nullptr));
    json["features"].push_back(plane.features.size());
    Json keyframes = Json::array();
    for (const PlaneView& view : plane.views) keyframes.push_back(view.keyframe.value);
    json["keyframes"].push_back(std::move(keyframes));
  }
  return json;
}

Json EdgesJson(const MapData& map) {
  Json json = {{"a", Json::array()}, {"b", Json::array()}, {"third_eigenvalue", Json::array()}};
  for (const Edge& edge : map.edges) {
    json["a"].push_back(edge.a.value);
    json["b"].push_back(edge.b.value);
    json["third_eigenvalue"].push_back(Rounded(edge.third_eigenvalue, 4));
  }
  return json;
}

}  // namespace

Json LayersJson(const MapData& map) {
  Json layers = Json::array();
  if (!map.planes.empty()) layers.push_back("planes");
  if (map.appearance) layers.push_back("appearance");
  if (map.orientation) layers.push_back("orientation");
  if (map.poses) layers.push_back("poses");
  return layers;
}

Json OverviewJson(const MapIndex& index) {
  Json json;
  json["layers"] = LayersJson(index.map());
  json["keyframes"] = KeyframesJson(index);
  json["planes"] = PlanesJson(index);
  json["edges"] = EdgesJson(index.map());
  return json;
}

}  // namespace waystone
