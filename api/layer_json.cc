// SPDX-License-Identifier: Apache-2.0
#include "api/layer_json.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/layers/orientation/orientation_trajectory.h"
#include "schema/layers/orientation/unknown_corridors.h"

namespace waystone {
namespace {

constexpr int kLengthDecimals = 4;
constexpr int kAngleDecimals = 5;

double Length(double value) { return Rounded(value, kLengthDecimals); }
double Angle(double value_rad) { return Rounded(value_rad, kAngleDecimals); }

Json HeadingJson(const OrientationFrame& frame) {
  if (!frame.rotation) return nullptr;
  const std::optional<double> heading = HeadingOf(*frame.rotation);
  return heading ? Json(Angle(*heading)) : Json(nullptr);
}

// Standard deviation of the heading, about the building's z.
Json HeadingSigmaJson(const OrientationFrame& frame) {
  if (!frame.rotation) return nullptr;
  return Angle(std::sqrt(std::max(0.0, frame.rotation->covariance(2, 2))));
}

bool Contains(const OrientationLayer& layer, const Corridor& corridor, OrientationFrameId id) {
  if (id < corridor.first || corridor.last < id) return false;
  const OrientationFrame* frame = FrameOf(layer, id);
  const OrientationFrame* first = FrameOf(layer, corridor.first);
  return frame && first && frame->sequence == first->sequence;
}

Json FindCorridor(const OrientationLayer& layer, OrientationFrameId frame) {
  for (size_t i = 0; i < layer.corridors.size(); ++i) {
    if (Contains(layer, layer.corridors[i], frame)) return i + 1;
  }
  return nullptr;
}

Json ImagePath(const std::string& map, const std::string& layer, int64_t node) {
  return "/v1/maps/" + EncodeSegment(map) + "/" + layer + "/nodes/" + std::to_string(node) +
         "/image";
}

std::string NameOf(const MapData& map, SequenceId id) {
  for (const Sequence& sequence : map.sequences) {
    if (sequence.id == id) return sequence.name;
  }
  return "";
}

Json HalvesJson(const HalfMatrix& matrix, int decimals) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    Json row = Json::array();
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
      row.push_back(Rounded(static_cast<float>(matrix(r, c)), decimals));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

const char* AxisName(int axis) { return axis == 0 ? "x" : "y"; }

// All frames, by columns.
Json FramesJson(const OrientationLayer& layer) {
  constexpr int kHeadingDecimals = 4;  // enough for a plot, and a third of the bytes
  Json json;
  for (const char* column : {"id", "sequence", "frame", "x", "y", "heading_rad", "reliable",
                             "lines_x", "lines_y", "lines_z"}) {
    json[column] = Json::array();
  }
  const std::vector<Eigen::Vector2d> trajectory = ComputeTrajectory(layer);
  for (size_t i = 0; i < layer.frames.size(); ++i) {
    const OrientationFrame& frame = layer.frames[i];
    const auto heading = frame.rotation ? HeadingOf(*frame.rotation) : std::nullopt;
    json["id"].push_back(frame.id.value);
    json["sequence"].push_back(frame.sequence.value);
    json["frame"].push_back(frame.frame);
    json["x"].push_back(trajectory[i].x());
    json["y"].push_back(trajectory[i].y());
    json["heading_rad"].push_back(heading ? Json(Rounded(*heading, kHeadingDecimals)) : nullptr);
    json["reliable"].push_back(frame.reliable);
    json["lines_x"].push_back(frame.lines[0]);
    json["lines_y"].push_back(frame.lines[1]);
    json["lines_z"].push_back(frame.lines[2]);
  }
  return json;
}

}  // namespace

const AppearanceLayer& AppearanceOf(const MapIndex& index) {
  if (index.map().appearance) return *index.map().appearance;
  throw MapError(ErrorCode::kNoLayer,
                 "this map has no appearance layer; build it from panoramas or from a rig that "
                 "covers the full circle");
}

const OrientationLayer& OrientationOf(const MapIndex& index) {
  if (index.map().orientation) return *index.map().orientation;
  throw MapError(ErrorCode::kNoLayer,
                 "this map has no orientation layer; build it from the images of a calibrated "
                 "camera");
}

const OrientationFrame* FrameOf(const OrientationLayer& layer, OrientationFrameId id) {
  const auto it = std::lower_bound(
      layer.frames.begin(), layer.frames.end(), id,
      [](const OrientationFrame& frame, OrientationFrameId wanted) { return frame.id < wanted; });
  return it == layer.frames.end() || it->id != id ? nullptr : &*it;
}

Json LayerJson(const MapData& map, const AppearanceLayer& layer) {
  const NodeRows rows("", map);
  Json json;
  json["scale"] = layer.metres_per_unit ? "metric" : "arbitrary";
  json["metres_per_unit"] = OrNull(layer.metres_per_unit);
  json["dropped"] = layer.dropped;
  json["nodes"] = Json::array();
  for (const AppearanceNode& node : layer.nodes) {
    json["nodes"].push_back({{"id", node.id.value},
                             {"keyframe", rows.KeyframeOf(node.sequence, node.frame)},
                             {"x", Length(node.pose.x)},
                             {"y", Length(node.pose.y)},
                             {"heading_rad", Angle(node.pose.theta_rad)}});
  }
  json["edges"] = Json::array();
  for (const AppearanceEdge& edge : layer.edges) {
    const bool loop = edge.kind == AppearanceEdgeKind::kLoop;
    json["edges"].push_back({{"a", edge.a.value},
                             {"b", edge.b.value},
                             {"kind", loop ? "loop" : "odometry"},
                             {"distance", Length(edge.distance)}});
  }
  return json;
}

Json LayerJson(const std::string& map_name, const MapData& map, const OrientationLayer& layer) {
  const NodeRows rows("", map);
  Json json;
  json["step"] = layer.step;
  json["frames"] = FramesJson(layer);
  json["nodes"] = Json::array();
  for (const OrientationNode& node : layer.nodes) {
    const OrientationFrame* frame = FrameOf(layer, node.frame);
    const bool turn = node.kind == OrientationNodeKind::kTurn;
    json["nodes"].push_back(
        {{"id", node.frame.value},
         {"keyframe", frame ? rows.KeyframeOf(frame->sequence, frame->frame) : Json(nullptr)},
         {"kind", turn ? "turn" : "frame"},
         {"heading_rad", frame ? HeadingJson(*frame) : Json(nullptr)},
         {"corridor", FindCorridor(layer, node.frame)},
         {"directions", node.directions},
         {"image", node.picture.empty() ? Json(nullptr)
                                        : ImagePath(map_name, "orientation", node.frame.value)}});
  }
  json["edges"] = Json::array();
  for (const OrientationEdge& edge : layer.edges) {
    const bool loop = edge.kind == OrientationEdgeKind::kLoop;
    json["edges"].push_back({{"a", edge.a.value},
                             {"b", edge.b.value},
                             {"kind", loop ? "loop" : "traversable"},
                             {"matches", edge.matches}});
  }
  json["turns"] = Json::array();
  for (const OrientationTurn& turn : layer.turns) json["turns"].push_back(TurnJson(turn));
  json["corridors"] = Json::array();
  for (size_t i = 0; i < layer.corridors.size(); ++i) {
    json["corridors"].push_back(CorridorJson(layer, i));
  }
  json["corridors_unknown"] = Json::array();
  for (const SequenceId sequence : ListSequencesWithUnknownCorridors(map)) {
    json["corridors_unknown"].push_back(sequence.value);
  }
  return json;
}

NodeRows::NodeRows(std::string map_name, const MapData& map)
    : name_(std::move(map_name)), map_(map) {
  for (const Keyframe& keyframe : map.keyframes) {
    keyframes_.emplace(std::pair(keyframe.sequence, keyframe.frame), keyframe.id);
  }
}

Json NodeRows::KeyframeOf(SequenceId sequence, int frame) const {
  const auto it = keyframes_.find({sequence, frame});
  return it == keyframes_.end() ? Json(nullptr) : Json(it->second.value);
}

Json NodeRows::Row(const AppearanceNode& node) const {
  Json json;
  json["id"] = node.id.value;
  json["sequence"] = NameOf(map_, node.sequence);
  json["sequence_id"] = node.sequence.value;
  json["source"] = node.source;
  const std::string* place = names_.OfNode(node);
  json["place"] = place ? Json(*place) : Json(nullptr);
  json["time_s"] = OrNull(node.time_s);
  json["frame"] = node.frame;
  json["keyframe"] = KeyframeOf(node.sequence, node.frame);
  json["x"] = Length(node.pose.x);
  json["y"] = Length(node.pose.y);
  json["heading_rad"] = Angle(node.pose.theta_rad);
  json["features"] = node.features.bearings.size();
  json["image"] =
      node.picture.empty() ? Json(nullptr) : ImagePath(name_, "appearance", node.id.value);
  return json;
}

Json NodeRows::Row(const OrientationFrame& frame) const {
  Json json;
  json["id"] = frame.id.value;
  json["sequence"] = NameOf(map_, frame.sequence);
  json["source"] = frame.source;
  json["time_s"] = OrNull(frame.time_s);
  json["frame"] = frame.frame;
  json["keyframe"] = KeyframeOf(frame.sequence, frame.frame);
  json["reliable"] = frame.reliable;
  json["heading_rad"] = HeadingJson(frame);
  json["deviation_rad"] = HeadingSigmaJson(frame);
  json["building_from_head"] =
      frame.rotation ? ToJson(Eigen::Matrix3d(frame.rotation->building_from_rig)) : Json(nullptr);
  json["lines"] = frame.lines;
  return json;
}

std::vector<AppearanceEdge> LoopsOf(const AppearanceLayer& layer) {
  std::vector<AppearanceEdge> loops;
  std::copy_if(layer.edges.begin(), layer.edges.end(), std::back_inserter(loops),
               [](const AppearanceEdge& edge) { return edge.kind == AppearanceEdgeKind::kLoop; });
  return loops;
}

Json LoopJson(const AppearanceEdge& edge) {
  Json json;
  json["a"] = edge.a.value;
  json["b"] = edge.b.value;
  json["distance"] = Length(edge.distance);
  json["a_from_b"] = {{"x", Length(edge.a_from_b.x)},
                      {"y", Length(edge.a_from_b.y)},
                      {"heading_rad", Angle(edge.a_from_b.theta_rad)}};
  json["deviation_rad"] = Angle(edge.sigma_rad);
  return json;
}

Json SignatureJson(const AppearanceNode& node) {
  constexpr int kDecimals = 4;  // 16-bit floats have no more
  Json json;
  json["node"] = node.id.value;
  json["magnitudes"] = HalvesJson(node.signature.magnitudes, kDecimals);
  json["phases"] = HalvesJson(node.signature.phases, kDecimals);
  return json;
}

Json TurnJson(const OrientationTurn& turn) {
  Json json;
  json["frame"] = turn.frame.value;
  json["direction"] = turn.direction > 0 ? "left" : "right";
  json["angle_rad"] = Angle(turn.angle_rad);
  json["confirmed"] = turn.confirmed;
  json["axis_after"] = AxisName(turn.axis_after);
  return json;
}

Json CorridorJson(const OrientationLayer& layer, size_t i) {
  const Corridor& corridor = layer.corridors[i];
  Json json;
  json["id"] = i + 1;
  json["axis"] = AxisName(corridor.axis);
  json["first"] = corridor.first.value;
  json["last"] = corridor.last.value;
  json["nodes"] = Json::array();
  for (const OrientationNode& node : layer.nodes) {
    if (Contains(layer, corridor, node.frame)) json["nodes"].push_back(node.frame.value);
  }
  return json;
}

}  // namespace waystone
