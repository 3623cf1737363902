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
#include "schema/sessions.h"

namespace waystone {
namespace {

// New ids for the rows of a list: those after the last of another list, in their order.
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

 private:
  std::map<IdType, IdType> ids_;
};

// Ranges hold what they held: new ids are in the order of the old ones, without others between.
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

// Of one frame. Errors are at most those of the worse one.
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
}

}  // namespace

void AppendMap(MapData from, MapData& to) {
  WS_CHECK(from.info.feature_type == to.info.feature_type, "maps of one feature type");
  const NewIds<SequenceId> sequence(to.sequences, from.sequences);
  const NewIds<KeyframeId> keyframe(to.keyframes, from.keyframes);
  const NewIds<PlaneId> plane(to.planes, from.planes);
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
  if (from.poses) {
    for (KeyframePose& row : from.poses->keyframes) row.keyframe = keyframe(row.keyframe);
    for (PlanePose& row : from.poses->planes) row.plane = plane(row.plane);
    for (PlaneDepths& row : from.poses->plane_depths) row.plane = plane(row.plane);
    for (LandmarkDepths& row : from.poses->landmark_depths) row.keyframe = keyframe(row.keyframe);
    AppendPoses(std::move(*from.poses), to.poses);
  }
  for (NamedPlace& place : from.names) {
    for (NamedRange& range : place.ranges) {
      if (range.kind == NamedKind::kKeyframes) Renumber(keyframe, range);
      if (range.kind == NamedKind::kPlanes) Renumber(plane, range);
    }
  }
  MoveBehind(from.names, to.names);
  to.names = Canonical(std::move(to.names));
  if (to.floor_plans.empty()) to.floor_plans = std::move(from.floor_plans);
  MoveBehind(from.sequences, to.sequences);
  MoveBehind(from.keyframes, to.keyframes);
  MoveBehind(from.planes, to.planes);
  MoveBehind(from.edges, to.edges);
  MoveBehind(from.links, to.links);
  to.info.options_json = WithSessions(to.info.options_json, sessions);
  to.index.reset();
  to.verdict.reset();
}

}  // namespace waystone
