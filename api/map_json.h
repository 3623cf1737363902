// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "api/json.h"
#include "localizer/index/map_index.h"

// The parts of a map as the HTTP API shows them. Matrices are three rows of three, points are [x,
// y] in pixels, links are by id. All functions are thread-safe.
namespace waystone {

// name, version, program, feature_type, keyframes, planes, surfaces, edges, features, names
// (counts), sequences, sessions and parts (SessionsJson, PartsJson).
Json MapJson(const std::string& name, const MapIndex& index);

// A plane in a list: id, surface (the one it is part of, by the lowest id of its planes),
// reference, features, views (counts), neighbours, outline.
Json PlaneSummaryJson(const MapIndex& index, const Plane& plane);
// The whole plane: the features and views themselves instead of their counts, too.
Json PlaneJson(const MapIndex& index, const Plane& plane);

// A feature of a plane, in its reference image; and a keyframe that saw the plane.
Json FeatureJson(const PlaneFeature& feature);
Json ViewJson(const PlaneView& view);

// Nodes and edges of the graph of planes, each node with its surface.
Json GraphJson(const MapIndex& index);

// A keyframe: id, sequence, source, time, size, the planes it saw with their surfaces, inliers,
// reference_from_keyframe and outline in the keyframe, and the address of its image (null when
// images were left out).
Json KeyframeJson(const std::string& map_name, const MapIndex& index, const Keyframe& keyframe);

// The same for many keyframes of a map; walks over the map's planes only once. Immutable after
// construction; thread-safe.
class KeyframeRows {
 public:
  // The index must outlive this.
  KeyframeRows(std::string map_name, const MapIndex& index);

  Json Row(const Keyframe& keyframe) const;

 private:
  struct SeenPlane {
    const Plane* plane;
    const PlaneView* view;
  };

  const std::string name_;
  const MapIndex& index_;
  std::map<KeyframeId, std::vector<SeenPlane>> seen_;  // by keyframe, in the order of the planes
};

// A plane's outline as a keyframe saw it, clipped to the keyframe, px.
std::vector<Eigen::Vector2d> OutlineIn(const Keyframe& keyframe, const Plane& plane,
                                       const PlaneView& view);

}  // namespace waystone
