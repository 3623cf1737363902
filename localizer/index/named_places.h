// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/ids.h"
#include "schema/layers/poses/horizontal.h"
#include "schema/map_data.h"

namespace waystone {

// What is known about where something is; unknown fields don't match any place.
struct PlaceEvidence {
  std::optional<KeyframeId> keyframe;
  std::optional<AppearanceNodeId> node;
  std::optional<PlaneId> plane;
  std::optional<Eigen::Vector2d> position;  // in the coordinates of polygons (NamedPolygon)
};

// In which named place something is. Where several contain it, the narrowest counts: the one with
// the fewest keyframes and panoramas, with a plane counting as the keyframes that view it; of
// equally narrow ones the first by name. Immutable; any number of threads may share it.
class NamedPlaces {
 public:
  NamedPlaces() = default;
  explicit NamedPlaces(const MapData& map);

  // The place's name, null where there is none. Valid as long as this object.
  const std::string* Find(const PlaceEvidence& evidence) const;
  // By a keyframe's or node's own id and position.
  const std::string* OfKeyframe(KeyframeId id) const;
  const std::string* OfNode(const AppearanceNode& node) const;

  // Positions in the coordinates of polygons; nothing where the map's polygons are in another
  // layer's frame, or the keyframe has no pose.
  std::optional<Eigen::Vector2d> PositionOf(KeyframeId id) const;
  std::optional<Eigen::Vector2d> PositionOf(const Eigen::Vector3d& in_pose_layer) const;
  std::optional<Eigen::Vector2d> PositionOf(const Pose2& in_appearance_layer) const;

  bool empty() const { return places_.empty(); }

 private:
  std::vector<NamedPlace> places_;                             // the narrowest first
  std::optional<Horizontal> view_;                             // nothing without a pose layer
  bool nodes_are_in_view_ = false;                             // their poses are in that layer
  std::unordered_map<KeyframeId, Eigen::Vector2d> positions_;  // of keyframes
};

}  // namespace waystone
