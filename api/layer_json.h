// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "api/json.h"
#include "localizer/index/map_index.h"

// The appearance and the orientation layer as the HTTP API shows them. Angles are in radians,
// headings counter-clockwise; positions are in the layer's own unit of length (metres_per_unit
// gives its size, where known). All functions are thread-safe.
namespace waystone {

// The layers. Throw MapError(kNoLayer) for a map without the layer.
const AppearanceLayer& AppearanceOf(const MapIndex& index);
const OrientationLayer& OrientationOf(const MapIndex& index);

// The whole layer for drawing: the schemas Appearance and Orientation of clients/openapi.yaml. The
// latter has its frames in columns, with x and y by ComputeTrajectory
// (schema/layers/orientation/orientation_trajectory.h); `corridors_unknown` are sequences of one
// camera, whose corridors can't be distinguished from rooms.
Json LayerJson(const MapData& map, const AppearanceLayer& layer);
Json LayerJson(const std::string& map_name, const MapData& map, const OrientationLayer& layer);

// A frame of the layer, by its id; null when it has none.
const OrientationFrame* FrameOf(const OrientationLayer& layer, OrientationFrameId id);

// The full rows of lists. A frame that is also a keyframe of the plane layer has the keyframe's id.
// Immutable after construction; thread-safe.
class NodeRows {
 public:
  // The map must outlive this.
  NodeRows(std::string map_name, const MapData& map);

  Json Row(const AppearanceNode& node) const;
  Json Row(const OrientationFrame& frame) const;
  // The keyframe of this frame of a sequence; null when there is none.
  Json KeyframeOf(SequenceId sequence, int frame) const;

 private:
  const std::string name_;
  const MapData& map_;
  const NamedPlaces names_{map_};
  std::map<std::pair<SequenceId, int>, KeyframeId> keyframes_;
};

// The edges that close loops, as in the layer; and such an edge as JSON.
std::vector<AppearanceEdge> LoopsOf(const AppearanceLayer& layer);
Json LoopJson(const AppearanceEdge& edge);
// A node's Fourier signature: magnitudes and phases, row by row of the panorama from above.
Json SignatureJson(const AppearanceNode& node);

Json TurnJson(const OrientationTurn& turn);
// Corridor `i` of the layer, which has the id i + 1: its axis, first and last frame, and nodes.
Json CorridorJson(const OrientationLayer& layer, size_t i);

// The id that names a node in a path.
inline AppearanceNodeId IdOf(const AppearanceNode& node) { return node.id; }
inline OrientationFrameId IdOf(const OrientationNode& node) { return node.frame; }

}  // namespace waystone
