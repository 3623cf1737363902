// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/append_map.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "schema/layers/names/place_names.h"
#include "schema/layers/poses/horizontal.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

// New ids for the rows of a list: those after the last id of another list, in order.
template <class IdType>
class NewIds {
 public:
  template <class Row>
  NewIds(const std::vector<Row>& before, const std::vector<Row>& added) {
    int64_t last = before.empty() ? 0 : before.back().id.value;
    if (last > std::numeric_limits<int64_t>::max() - std::ssize(added)) {
      throw MapError(ErrorCode::kMapDamaged, "the last id of a map is " + std::to_string(last) +
                                                 ", which leaves no room for those of another; "
                                                 "build the map again");
    }
    for (const Row& row : added) ids_.emplace(row.id, IdType{++last});
  }

  IdType operator()(IdType old) const { return ids_.at(old); }
  const std::map<IdType, IdType>& all() const { return ids_; }

 private:
  std::map<IdType, IdType> ids_;
};

// Ranges keep their contents: new ids are in the order of the old ones, without others between.
template <class IdType>
void Renumber(const NewIds<IdType>& ids, NamedRange& range) {
  range.first = ids({range.first}).value;
  range.last = ids({range.last}).value;
}

// Stretches without gaps, after those of `to`.
void RenumberStretches(const MapData& to, std::vector<Keyframe>& keyframes) {
  std::map<int, int> renumbered;
  for (const Keyframe& keyframe : keyframes) renumbered[keyframe.stretch] = 0;
  int64_t next = 0;
  for (const Keyframe& keyframe : to.keyframes) {
    next = std::max<int64_t>(next, int64_t{keyframe.stretch} + 1);
  }
  if (next + std::ssize(renumbered) > std::numeric_limits<int>::max()) {
    throw MapError(ErrorCode::kMapDamaged,
                   "a keyframe is in stretch " + std::to_string(next - 1) +
                       ", which leaves no room for those of another map; build the map again");
  }
  for (auto& [old, renamed] : renumbered) renamed = static_cast<int>(next++);
  for (Keyframe& keyframe : keyframes) keyframe.stretch = renumbered.at(keyframe.stretch);
}

template <class Row>
void MoveBehind(std::vector<Row>& added, std::vector<Row>& to) {
  std::ranges::move(added, std::back_inserter(to));
}

void AppendPanoramas(AppearanceLayer from, std::optional<AppearanceLayer>& to) {
  if (!to) {
    to = std::move(from);
    return;
  }
  to->dropped += std::min(from.dropped, std::numeric_limits<int>::max() - to->dropped);
  if (!to->mirror) to->mirror = from.mirror;
  if (to->metres_per_unit != from.metres_per_unit) to->metres_per_unit.reset();
  MoveBehind(from.nodes, to->nodes);
  MoveBehind(from.edges, to->edges);
  to->verdict.reset();
  to->verified_verdict.reset();
}

void AppendOrientation(OrientationLayer from, std::optional<OrientationLayer>& to) {
  if (!to) {
    to = std::move(from);
    return;
  }
  MoveBehind(from.frames, to->frames);
  MoveBehind(from.turns, to->turns);
  MoveBehind(from.nodes, to->nodes);
  MoveBehind(from.edges, to->edges);
  MoveBehind(from.corridors, to->corridors);
}

std::optional<NodePoseErrors> WorseOf(const std::optional<NodePoseErrors>& a,
                                      const std::optional<NodePoseErrors>& b) {
  if (!a || !b) return a ? a : b;
  return NodePoseErrors{std::max(a->position_factor, b->position_factor),
                        std::max(a->height_sigma, b->height_sigma),
                        std::max(a->heading_sigma_rad, b->heading_sigma_rad),
                        std::max(a->tilt_sigma_rad, b->tilt_sigma_rad)};
}

// Both layers are in one frame. Errors are those of the worse one.
void AppendPoses(PoseLayer from, std::optional<PoseLayer>& to) {
  if (!to) {
    to = std::move(from);
    return;
  }
  PoseNoise& noise = to->noise;
  noise.position_sigma = std::max(noise.position_sigma, from.noise.position_sigma);
  noise.rotation_sigma_rad = std::max(noise.rotation_sigma_rad, from.noise.rotation_sigma_rad);
  MoveBehind(from.keyframes, to->keyframes);
  MoveBehind(from.planes, to->planes);
  MoveBehind(from.plane_depths, to->plane_depths);
  MoveBehind(from.landmark_depths, to->landmark_depths);
  MoveBehind(from.nodes, to->nodes);
  to->appearance_errors = WorseOf(to->appearance_errors, from.appearance_errors);
  to->verified_errors = WorseOf(to->verified_errors, from.verified_errors);
}

// The layers whose rows have ids of their own.
void RenumberPanoramas(const NewIds<SequenceId>& sequence, const NewIds<AppearanceNodeId>& node,
                       AppearanceLayer& layer) {
  for (AppearanceNode& row : layer.nodes) {
    row.id = node(row.id);
    row.sequence = sequence(row.sequence);
  }
  for (AppearanceEdge& row : layer.edges) {
    row.a = node(row.a);
    row.b = node(row.b);
  }
}

void RenumberOrientation(const NewIds<SequenceId>& sequence,
                         const NewIds<OrientationFrameId>& frame, OrientationLayer& layer) {
  for (OrientationFrame& row : layer.frames) {
    row.id = frame(row.id);
    row.sequence = sequence(row.sequence);
  }
  for (OrientationTurn& row : layer.turns) row.frame = frame(row.frame);
  for (OrientationNode& row : layer.nodes) row.frame = frame(row.frame);
  for (OrientationEdge& row : layer.edges) {
    row.a = frame(row.a);
    row.b = frame(row.b);
  }
  for (Corridor& row : layer.corridors) {
    row.first = frame(row.first);
    row.last = frame(row.last);
  }
}

template <class Layer, class Row>
const std::vector<Row>& RowsOf(const std::optional<Layer>& layer, std::vector<Row> Layer::*rows) {
  static const std::vector<Row> none;
  return layer ? (*layer).*rows : none;
}

}  // namespace

void PutNodesIntoFrame(MapData& map) {
  if (!map.poses || !map.appearance) return;
  const Horizontal above = HorizontalOf(*map.poses);
  for (AppearanceNode& node : map.appearance->nodes) {
    if (const NodePose* pose = map.poses->Find(node.id)) node.pose = above.Of(*pose);
  }
}

std::map<SequenceId, SequenceId> AppendedSequences(const MapData& from, const MapData& to) {
  return NewIds<SequenceId>(to.sequences, from.sequences).all();
}

void AppendMap(MapData from, MapData& to) {
  WS_CHECK(from.info.feature_type == to.info.feature_type, "maps of one feature type");
  const NewIds<SequenceId> sequence(to.sequences, from.sequences);
  const NewIds<KeyframeId> keyframe(to.keyframes, from.keyframes);
  const NewIds<PlaneId> plane(to.planes, from.planes);
  const NewIds<AppearanceNodeId> node(RowsOf(to.appearance, &AppearanceLayer::nodes),
                                      RowsOf(from.appearance, &AppearanceLayer::nodes));
  const NewIds<OrientationFrameId> frame(RowsOf(to.orientation, &OrientationLayer::frames),
                                         RowsOf(from.orientation, &OrientationLayer::frames));
  std::vector<MapSession> sessions = SessionsOf(to);
  for (MapSession& session : SessionsOf(from)) {
    for (SequenceId& id : session.sequences) id = sequence(id);
    sessions.push_back(std::move(session));
  }
  for (Sequence& row : from.sequences) row.id = sequence(row.id);
  RenumberStretches(to, from.keyframes);
  for (Keyframe& row : from.keyframes) {
    row.id = keyframe(row.id);
    row.sequence = sequence(row.sequence);
  }
  for (Plane& row : from.planes) {
    row.id = plane(row.id);
    row.reference = keyframe(row.reference);
    for (PlaneView& view : row.views) view.keyframe = keyframe(view.keyframe);
  }
  for (Edge& row : from.edges) {
    row.a = plane(row.a);
    row.b = plane(row.b);
    row.from = keyframe(row.from);
    row.to = keyframe(row.to);
  }
  for (KeyframeLink& link : from.links) link = {keyframe(link.a), keyframe(link.b)};
  for (PlaneLooks& row : from.looks.planes) {
    row.plane = plane(row.plane);
    row.sequence = sequence(row.sequence);
  }
  for (LandmarkLooks& row : from.looks.landmarks) {
    row.keyframe = keyframe(row.keyframe);
    row.sequence = sequence(row.sequence);
  }
  if (from.poses) {
    for (KeyframePose& row : from.poses->keyframes) row.keyframe = keyframe(row.keyframe);
    for (PlanePose& row : from.poses->planes) row.plane = plane(row.plane);
    for (PlaneDepths& row : from.poses->plane_depths) row.plane = plane(row.plane);
    for (LandmarkDepths& row : from.poses->landmark_depths) row.keyframe = keyframe(row.keyframe);
    for (NodePose& row : from.poses->nodes) row.node = node(row.node);
    AppendPoses(std::move(*from.poses), to.poses);
  }
  if (from.appearance) {
    RenumberPanoramas(sequence, node, *from.appearance);
    AppendPanoramas(std::move(*from.appearance), to.appearance);
  }
  PutNodesIntoFrame(to);
  if (from.orientation) {
    RenumberOrientation(sequence, frame, *from.orientation);
    AppendOrientation(std::move(*from.orientation), to.orientation);
  }
  for (NamedPlace& place : from.names) {
    for (NamedRange& range : place.ranges) {
      if (range.kind == NamedKind::kKeyframes) Renumber(keyframe, range);
      if (range.kind == NamedKind::kPlanes) Renumber(plane, range);
      if (range.kind == NamedKind::kNodes) Renumber(node, range);
    }
  }
  MoveBehind(from.names, to.names);
  to.names = Canonical(std::move(to.names));
  if (to.floor_plans.empty()) to.floor_plans = std::move(from.floor_plans);
  MoveBehind(from.sequences, to.sequences);
  if (to.keyframes.empty()) {
    to.verdict = from.verdict;
  } else if (!from.keyframes.empty()) {
    to.verdict.reset();
  }
  MoveBehind(from.keyframes, to.keyframes);
  MoveBehind(from.planes, to.planes);
  MoveBehind(from.edges, to.edges);
  MoveBehind(from.links, to.links);
  MoveBehind(from.looks.planes, to.looks.planes);
  MoveBehind(from.looks.landmarks, to.looks.landmarks);
  to.info.options_json = WithSessions(to.info.options_json, sessions);
  to.index.reset();
}

}  // namespace waystone
