// SPDX-License-Identifier: Apache-2.0
#include "api/pose_formats.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>
#include <unordered_map>

#include "api/json.h"
#include "core/base/error.h"
#include "localizer/index/named_places.h"
#include "schema/layers/poses/horizontal.h"

namespace waystone {
namespace {

[[noreturn]] void CannotGive(const std::string& reason) {
  throw MapError(ErrorCode::kNotAvailable, reason);
}

// What the formats contain: the layer with scaled lengths.
struct PoseGraph {
  const MapData& map;
  const AppearanceLayer& layer;
  double scale = 1;  // of the lengths below
  std::string unit;  // "m", or "unit" of the layer

  Pose2 Scaled(const Pose2& pose) const { return {scale * pose.x, scale * pose.y, pose.theta_rad}; }
  std::string UnitText() const {
    return unit == "m" ? "metres" : "units of the layer (unknown scale)";
  }
};

PoseGraph CollectPoseGraph(const MapData& map) {
  if (!map.appearance) {
    CannotGive(
        "this format exports the appearance layer, which this map doesn't have; use graphml or "
        "dot, or geojson for a map with poses");
  }
  const std::optional<double> metres = map.appearance->metres_per_unit;
  return {map, *map.appearance, metres.value_or(1), metres ? "m" : "unit"};
}

// Whether the appearance layer is in the frame of given poses, which some formats contain in full,
// without nodes that have no pose.
bool IsInGivenFrame(const MapData& map) { return map.poses && !map.poses->nodes.empty(); }

std::string SequenceName(const MapData& map, SequenceId id) {
  for (const Sequence& sequence : map.sequences) {
    if (sequence.id == id) return sequence.name;
  }
  return "";
}

// One word of a line: formats whose fields are separated by blanks don't support quotes.
std::string Word(const std::string& text) {
  std::string word;
  for (const char c : text) word += static_cast<unsigned char>(c) <= ' ' ? '_' : c;
  return word.empty() ? "_" : word;
}

// Standard deviation of an edge's position (see the header).
class PositionSigma {
 public:
  explicit PositionSigma(const PoseGraph& graph) : graph_(graph) {
    for (const AppearanceEdge& edge : graph.layer.edges) mean_ += LengthOf(edge);
    if (!graph.layer.edges.empty()) mean_ /= static_cast<double>(graph.layer.edges.size());
    if (!(mean_ > 0)) mean_ = 1;
  }

  double Of(const AppearanceEdge& edge) const { return std::max(LengthOf(edge) / 2, mean_ / 10); }

 private:
  double LengthOf(const AppearanceEdge& edge) const {
    return graph_.scale * std::hypot(edge.a_from_b.x, edge.a_from_b.y);
  }

  const PoseGraph& graph_;
  double mean_ = 0;
};

std::string G2o(const PoseGraph& graph) {
  constexpr double kMinSigmaRad = 1e-4;  // 0 would be infinite information
  std::ostringstream out;
  out.exceptions(std::ios::badbit);  // for memory that runs out
  out.precision(12);
  out << "# " << graph.map.info.program << "; lengths in " << graph.UnitText() << '\n';
  for (const AppearanceNode& node : graph.layer.nodes) {
    const Pose2 pose = graph.Scaled(node.pose);
    out << "VERTEX_SE2 " << node.id.value << ' ' << pose.x << ' ' << pose.y << ' ' << pose.theta_rad
        << '\n';
  }
  const PositionSigma sigma(graph);
  for (const AppearanceEdge& edge : graph.layer.edges) {
    const Pose2 pose = graph.Scaled(edge.a_from_b);
    const double position = 1 / std::pow(sigma.Of(edge), 2);
    const double heading = 1 / std::pow(std::max(edge.sigma_rad, kMinSigmaRad), 2);
    out << "EDGE_SE2 " << edge.a.value << ' ' << edge.b.value << ' ' << pose.x << ' ' << pose.y
        << ' ' << pose.theta_rad << ' ' << position << " 0 0 " << position << " 0 " << heading
        << '\n';
  }
  return out.str();
}

Json PointJson(const Pose2& pose) { return {Rounded(pose.x, 4), Rounded(pose.y, 4)}; }

// Counter-clockwise and closed, as rings in RFC 7946.
Json RingJson(NamedPolygon polygon, double scale) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i] - polygon[0];
    const Eigen::Vector2d b = polygon[(i + 1) % polygon.size()] - polygon[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  if (twice < 0) std::reverse(polygon.begin(), polygon.end());
  polygon.push_back(polygon.front());
  Json ring = Json::array();
  for (const Eigen::Vector2d& corner : polygon) {
    ring.push_back({Rounded(scale * corner.x(), 4), Rounded(scale * corner.y(), 4)});
  }
  return ring;
}

// The polygons of named places.
void AddPlaces(const MapData& map, double scale, Json& features) {
  for (const NamedPlace& place : map.names) {
    for (const NamedPolygon& polygon : place.polygons) {
      features.push_back(
          {{"type", "Feature"},
           {"geometry",
            {{"type", "Polygon"}, {"coordinates", Json::array({RingJson(polygon, scale)})}}},
           {"properties", {{"kind", "place"}, {"place", place.name}}}});
    }
  }
}

// The name of what is at a point, on maps with names.
void AddPlaceName(const NamedPlaces& names, const std::string* name, Json& properties) {
  if (!names.empty()) properties["place"] = name ? Json(*name) : Json(nullptr);
}

// `view` is given where positions have three coordinates.
std::string CollectionText(const std::string& frame_name, const std::string& unit,
                           const std::optional<Horizontal>& view, Json features) {
  Json frame = {{"name", frame_name}, {"unit", unit}};
  if (view) {
    frame["right"] = {view->right.x(), view->right.y(), view->right.z()};
    frame["top"] = {view->top.x(), view->top.y(), view->top.z()};
    frame["note"] =
        "coordinates are along 'right' and 'top', directions in the map's own frame, "
        "not degrees";
  } else {
    frame["note"] = "coordinates are x and y of the map's own frame, not degrees";
  }
  const Json json = {
      {"type", "FeatureCollection"}, {"frame", frame}, {"features", std::move(features)}};
  return Dump(json) + "\n";
}

// The keyframes of a map with poses, from above.
void AddKeyframes(const MapData& map, const PoseLayer& layer, Json& features) {
  const Horizontal view = HorizontalOf(layer);
  const NamedPlaces names(map);
  for (const KeyframePose& pose : layer.keyframes) {
    const auto keyframe =
        std::lower_bound(map.keyframes.begin(), map.keyframes.end(), pose.keyframe,
                         [](const Keyframe& one, KeyframeId id) { return one.id < id; });
    if (keyframe == map.keyframes.end() || keyframe->id != pose.keyframe) continue;
    const Pose2 at = view.Of(pose);
    Json properties = {{"sequence", SequenceName(map, keyframe->sequence)},
                       {"source", keyframe->source},
                       {"time_s", OrNull(keyframe->time_s)},
                       {"heading_rad", Rounded(at.theta_rad, 5)}};
    AddPlaceName(names, names.OfKeyframe(keyframe->id), properties);
    features.push_back({{"type", "Feature"},
                        {"id", keyframe->id.value},
                        {"geometry", {{"type", "Point"}, {"coordinates", PointJson(at)}}},
                        {"properties", std::move(properties)}});
  }
}

// A map with poses but without an appearance layer.
std::string KeyframesGeoJson(const MapData& map, const PoseLayer& layer) {
  Json features = Json::array();
  AddKeyframes(map, layer, features);
  AddPlaces(map, 1, features);
  return CollectionText(layer.frame, layer.unit == LengthUnit::kMetres ? "m" : "unit",
                        HorizontalOf(layer), std::move(features));
}

std::string GeoJson(const PoseGraph& graph) {
  Json features = Json::array();
  const NamedPlaces names(graph.map);
  std::unordered_map<AppearanceNodeId, Json> points;
  for (const AppearanceNode& node : graph.layer.nodes) {
    const Json& point = points[node.id] = PointJson(graph.Scaled(node.pose));
    Json properties = {{"sequence", SequenceName(graph.map, node.sequence)},
                       {"source", node.source},
                       {"time_s", OrNull(node.time_s)},
                       {"heading_rad", Rounded(node.pose.theta_rad, 5)}};
    AddPlaceName(names, names.OfNode(node), properties);
    features.push_back({{"type", "Feature"},
                        {"id", node.id.value},
                        {"geometry", {{"type", "Point"}, {"coordinates", point}}},
                        {"properties", std::move(properties)}});
  }
  for (const AppearanceEdge& edge : graph.layer.edges) {
    const bool loop = edge.kind == AppearanceEdgeKind::kLoop;
    const Json line = Json::array({points[edge.a], points[edge.b]});
    features.push_back({{"type", "Feature"},
                        {"geometry", {{"type", "LineString"}, {"coordinates", line}}},
                        {"properties", {{"kind", loop ? "loop" : "odometry"}}}});
  }
  // Keyframes and polygons of a map that has both are in the frame of its poses.
  const bool in_given_frame = IsInGivenFrame(graph.map);
  if (in_given_frame) AddKeyframes(graph.map, *graph.map.poses, features);
  if (in_given_frame || !graph.map.poses) AddPlaces(graph.map, graph.scale, features);
  if (!in_given_frame) return CollectionText("layer", graph.unit, {}, std::move(features));
  return CollectionText(graph.map.poses->frame, graph.unit, HorizontalOf(*graph.map.poses),
                        std::move(features));
}

std::string Ply(const PoseGraph& graph) {
  std::ostringstream out;
  out.exceptions(std::ios::badbit);  // for memory that runs out
  out.precision(9);
  out << "ply\nformat ascii 1.0\ncomment lengths in " << graph.UnitText() << "\nelement vertex "
      << graph.layer.nodes.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty int node\nelement edge "
      << graph.layer.edges.size()
      << "\nproperty int vertex1\nproperty int vertex2\nproperty uchar loop\nend_header\n";
  std::unordered_map<AppearanceNodeId, size_t> row;
  for (const AppearanceNode& node : graph.layer.nodes) {
    row.emplace(node.id, row.size());
    const NodePose* given = graph.map.poses ? graph.map.poses->Find(node.id) : nullptr;
    const Pose2 pose = graph.Scaled(node.pose);
    const Eigen::Vector3d at = given ? given->position : Eigen::Vector3d(pose.x, pose.y, 0);
    out << at.x() << ' ' << at.y() << ' ' << at.z() << ' ' << node.id.value << '\n';
  }
  for (const AppearanceEdge& edge : graph.layer.edges) {
    out << row.at(edge.a) << ' ' << row.at(edge.b) << ' '
        << (edge.kind == AppearanceEdgeKind::kLoop ? 1 : 0) << '\n';
  }
  return out.str();
}

// A node's pose from that in the layer: x ahead, y to the left, z up.
CameraPose BodyPose(const Pose2& pose) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(pose.theta_rad, Eigen::Vector3d::UnitZ()));
  return {q, Eigen::Vector3d(pose.x, pose.y, 0)};
}

std::string Tum(const PoseGraph& graph) {
  const std::vector<AppearanceNode>& nodes = graph.layer.nodes;
  const bool given = IsInGivenFrame(graph.map);
  const bool timed =
      std::all_of(nodes.begin(), nodes.end(), [](const auto& n) { return n.time_s.has_value(); });
  std::ostringstream out;
  out.exceptions(std::ios::badbit);  // for memory that runs out
  out << "# " << (timed ? "time_s" : "frame number (not all nodes have a time)")
      << " x y z qx qy qz qw; "
      << (given ? "the camera's x right, y down, z forward" : "x forward, z up") << "; lengths in "
      << graph.UnitText() << '\n';
  SequenceId sequence;
  for (const AppearanceNode& node : nodes) {
    if (node.sequence != sequence) {
      out << "# sequence " << Word(SequenceName(graph.map, node.sequence)) << '\n';
      sequence = node.sequence;
    }
    const NodePose* known = given ? graph.map.poses->Find(node.id) : nullptr;
    if (given && !known) continue;
    const CameraPose pose = known ? CameraPose(*known) : BodyPose(graph.Scaled(node.pose));
    const Eigen::Vector3d& at = pose.position;
    const Eigen::Quaterniond& q = pose.rotation;
    char line[300];
    (void)std::snprintf(line, sizeof line, "%.6f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n",
                        timed ? *node.time_s : node.frame, at.x(), at.y(), at.z(), q.x(), q.y(),
                        q.z(), q.w());
    out << line;
  }
  return out.str();
}

std::string ResultLines(const PoseGraph& graph) {
  if (graph.unit != "m") {
    CannotGive(
        "the visuallocalization.net format is in metres, and the scale of this map's appearance "
        "layer is unknown; use tum");
  }
  // The front camera's axes in the node's frame: x right, y down, z forward of x ahead, y left.
  Eigen::Matrix3d node_from_camera;
  node_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const bool given = IsInGivenFrame(graph.map);
  std::ostringstream out;
  out.exceptions(std::ios::badbit);  // for memory that runs out
  out.precision(9);
  for (const AppearanceNode& node : graph.layer.nodes) {
    const NodePose* known = given ? graph.map.poses->Find(node.id) : nullptr;
    if (given && !known) continue;
    const CameraPose body = BodyPose(graph.Scaled(node.pose));
    const Eigen::Matrix3d world_from_camera =
        known ? known->rotation.toRotationMatrix()
              : Eigen::Matrix3d(body.rotation.toRotationMatrix() * node_from_camera);
    Eigen::Quaterniond q(Eigen::Matrix3d(world_from_camera.transpose()));
    if (q.w() < 0) q.coeffs() *= -1;
    const Eigen::Vector3d t = -(q * (known ? known->position : body.position));
    out << Word(node.source) << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' '
        << t.x() << ' ' << t.y() << ' ' << t.z() << '\n';
  }
  return out.str();
}

struct PoseFormat {
  const char* name;
  const char* media_type;
  std::string (*write)(const PoseGraph&);
};
constexpr PoseFormat kFormats[] = {
    {"g2o", "text/plain; charset=utf-8", G2o},
    {"geojson", "application/geo+json", GeoJson},
    {"ply", "text/plain; charset=utf-8", Ply},
    {"tum", "text/plain; charset=utf-8", Tum},
    {"poses", "text/plain; charset=utf-8", ResultLines},
};

}  // namespace

std::vector<std::string> PoseFormatNames() {
  std::vector<std::string> names;
  for (const PoseFormat& format : kFormats) names.emplace_back(format.name);
  return names;
}

std::optional<GraphText> FormatPoses(const MapData& map, const std::string& format) {
  for (const PoseFormat& known : kFormats) {
    if (format != known.name) continue;
    if (known.write == GeoJson && map.poses && !map.appearance) {
      return GraphText{KeyframesGeoJson(map, *map.poses), known.media_type};
    }
    return GraphText{known.write(CollectPoseGraph(map)), known.media_type};
  }
  return std::nullopt;
}

}  // namespace waystone
