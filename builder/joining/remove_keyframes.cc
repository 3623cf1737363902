// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/remove_keyframes.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "builder/joining/append_map.h"
#include "builder/joining/joinable.h"
#include "builder/joining/kept_looks.h"
#include "builder/joining/kept_poses.h"
#include "builder/planes/outline.h"
#include "builder/planes/plane_features.h"
#include "core/base/error.h"
#include "core/homography/homography.h"
#include "core/homography/homology.h"
#include "schema/layers/planes/surfaces.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

using KeyframesById = std::map<KeyframeId, const Keyframe*>;

// Where a feature may lie outside of an image that showed it: positions have errors.
constexpr double kSeenMargin = 0.02;  // of its size
// Limits of the eigenvalues (1, 1, third) of two planes from stored homographies: beyond these they
// are too noisy for an edge.
constexpr double kMaxSplit = 0.2;
constexpr double kLeastThird = 0.1;

// The first of `removed` that isn't among the rows.
template <class Row, class IdType>
void CheckKnown(const std::vector<Row>& rows, const std::set<IdType>& removed,
                const std::string& noun) {
  std::set<IdType> unknown = removed;
  for (const Row& row : rows) unknown.erase(row.id);
  if (unknown.empty()) return;
  throw MapError(
      ErrorCode::kNotFound,
      "the map has no " + noun + " " + std::to_string(unknown.begin()->value) +
          (rows.empty() ? "; it has no " + noun + "s"
                        : "; its " + noun + "s are " + std::to_string(rows.front().id.value) +
                              " to " + std::to_string(rows.back().id.value)));
}

void CheckRemoval(const MapData& map, const Removal& removed) {
  const std::vector<AppearanceNode> none;
  const auto& nodes = map.appearance ? map.appearance->nodes : none;
  CheckKnown(map.keyframes, removed.keyframes, "keyframe");
  CheckKnown(nodes, removed.nodes, "panorama");
  if (removed.keyframes.size() < map.keyframes.size() || removed.nodes.size() < nodes.size())
    return;
  const size_t frames = map.orientation ? map.orientation->frames.size() : 0;
  if (FramesThatGo(map, removed).size() < frames) return;
  std::string all = nodes.empty() ? "" : std::to_string(nodes.size()) + " panoramas";
  if (!map.keyframes.empty() || nodes.empty()) {
    all = std::to_string(map.keyframes.size()) + " keyframes" + (all.empty() ? "" : " and ") + all;
  }
  throw MapError(ErrorCode::kBadRequest,
                 "all " + all + " would be removed; delete the file instead");
}

// Keyframes before and after a gap no longer follow each other: each remaining run becomes a
// stretch.
void RemoveFrom(std::vector<Keyframe>& keyframes, const std::set<KeyframeId>& removed) {
  std::vector<Keyframe> left;
  int stretch = -1;
  const Keyframe* last = nullptr;
  int last_stretch = 0;
  for (Keyframe& keyframe : keyframes) {
    if (removed.contains(keyframe.id)) {
      last = nullptr;
      continue;
    }
    if (last == nullptr || last->sequence != keyframe.sequence ||
        last_stretch != keyframe.stretch) {
      ++stretch;
    }
    last = &keyframe;
    last_stretch = keyframe.stretch;
    left.push_back(keyframe);
    left.back().stretch = stretch;
  }
  keyframes = std::move(left);
}

// Expresses a plane in the image of one of its views.
void Anchor(const PlaneView& view, Plane& plane) {
  const Matrix3d to_from = view.reference_from_keyframe.inverse();
  for (PlaneFeature& feature : plane.features) {
    feature.reference = Transferred(to_from, feature.reference);
  }
  plane.reference = view.keyframe;
  for (PlaneView& other : plane.views) {
    other.reference_from_keyframe = other.keyframe == plane.reference
                                        ? Matrix3d::Identity()
                                        : Normalised(to_from * other.reference_from_keyframe);
  }
}

bool IsFinite(const Keypoint& keypoint) {
  return std::isfinite(keypoint.x_px) && std::isfinite(keypoint.y_px) &&
         std::isfinite(keypoint.scale_px) && std::isfinite(keypoint.angle_rad);
}

bool Shows(const Keyframe& keyframe, const Matrix3d& keyframe_from_reference,
           const Vector2d& reference) {
  if (!IsInFront(keyframe_from_reference, reference)) return false;
  const Vector2d x = Apply(keyframe_from_reference, reference);
  return x.allFinite() && IsWithinReach(x, keyframe.width, keyframe.height, kSeenMargin);
}

// Removes features that no view shows; votes are capped at what the views can have given.
void KeepShown(const KeyframesById& keyframes, Plane& plane) {
  std::vector<std::pair<const Keyframe*, Matrix3d>> views;
  for (const PlaneView& view : plane.views) {
    views.emplace_back(keyframes.at(view.keyframe), view.reference_from_keyframe.inverse());
  }
  std::vector<int> kept;
  for (int f = 0; f < static_cast<int>(plane.features.size()); ++f) {
    PlaneFeature& feature = plane.features[f];
    if (!IsFinite(feature.reference)) continue;
    const Vector2d at = PositionOf(feature.reference);
    const auto shown = std::ranges::count_if(
        views, [&](const auto& view) { return Shows(*view.first, view.second, at); });
    if (shown == 0) continue;
    kept.push_back(f);
    feature.visible = std::min(feature.visible, static_cast<int>(shown));
    feature.votes = std::clamp(feature.votes, 1, std::max<int>(1, static_cast<int>(shown)));
  }
  KeepFeatures(kept, plane);
}

// The plane without the views that are gone; nothing when too little of it is left.
std::optional<Plane> Without(const std::set<KeyframeId>& removed, const KeyframesById& keyframes,
                             int min_features, Plane plane, RemoveReport& report) {
  const size_t views = plane.views.size();
  std::erase_if(plane.views,
                [&](const PlaneView& view) { return removed.contains(view.keyframe); });
  if (plane.views.size() == views) return plane;
  if (plane.views.empty()) return std::nullopt;
  if (removed.contains(plane.reference)) {
    Anchor(PlaneView(plane.views.front()), plane);
    ++report.planes_anchored;
  }
  KeepShown(keyframes, plane);
  if (static_cast<int>(plane.features.size()) < min_features) return std::nullopt;
  return plane;
}

// The first two keyframes that saw both planes: their views of each.
struct CommonViews {
  const PlaneView* a_from = nullptr;
  const PlaneView* b_from = nullptr;
  const PlaneView* a_to = nullptr;
  const PlaneView* b_to = nullptr;
};

std::optional<CommonViews> FindCommonViews(const Plane& a, const Plane& b) {
  CommonViews common;
  for (const PlaneView& view : a.views) {
    const auto found = std::ranges::lower_bound(b.views, view.keyframe, {}, &PlaneView::keyframe);
    if (found == b.views.end() || found->keyframe != view.keyframe) continue;
    if (common.a_from != nullptr) {
      common.a_to = &view;
      common.b_to = &*found;
      return common;
    }
    common.a_from = &view;
    common.b_from = &*found;
  }
  return std::nullopt;
}

// H^{ab} of two other keyframes: (H^a)^-1 H^b, each by the reference image of its plane.
std::optional<Edge> Recomputed(const Plane& a, const Plane& b) {
  const std::optional<CommonViews> common = FindCommonViews(a, b);
  if (!common) return std::nullopt;
  const auto from_to = [](const PlaneView& from, const PlaneView& to) {
    return Matrix3d(from.reference_from_keyframe.inverse() * to.reference_from_keyframe);
  };
  const Matrix3d homology =
      from_to(*common->a_from, *common->a_to).inverse() * from_to(*common->b_from, *common->b_to);
  if (!homology.allFinite()) return std::nullopt;
  const HomologyEigenvalues values = ComputeEigenvalues(homology);
  const bool valid = values.split < kMaxSplit && std::abs(values.third) > kLeastThird &&
                     std::abs(values.third) < 1 / kLeastThird;  // not for NaN
  if (!valid) return std::nullopt;
  return Edge{
      a.id,        b.id, common->a_from->keyframe, common->a_to->keyframe, homology / values.scale,
      values.third};
}

// The edge where its keyframes remain, a replacement, or nothing.
std::optional<Edge> Kept(const Edge& edge, const std::set<KeyframeId>& removed,
                         const std::map<PlaneId, const Plane*>& planes) {
  const auto a = planes.find(edge.a);
  const auto b = planes.find(edge.b);
  if (a == planes.end() || b == planes.end()) return std::nullopt;
  if (!removed.contains(edge.from) && !removed.contains(edge.to)) return edge;
  if (JoinsOneSurface(edge)) {  // whatever the keyframes
    Edge kept = edge;
    std::tie(kept.from, kept.to) = std::minmax({a->second->reference, b->second->reference});
    return kept;
  }
  return Recomputed(*a->second, *b->second);
}

void RemoveFromPlanes(const std::set<KeyframeId>& removed, int min_features, MapData& map,
                      RemoveReport& report) {
  KeyframesById keyframes;
  for (const Keyframe& keyframe : map.keyframes) keyframes[keyframe.id] = &keyframe;
  std::vector<Plane> planes;
  for (Plane& plane : map.planes) {
    auto left = Without(removed, keyframes, min_features, std::move(plane), report);
    if (left) planes.push_back(std::move(*left));
  }
  report.planes = static_cast<int>(map.planes.size() - planes.size());
  map.planes = std::move(planes);
  std::map<PlaneId, const Plane*> by_id;
  for (const Plane& plane : map.planes) by_id[plane.id] = &plane;
  std::vector<Edge> edges;
  for (const Edge& edge : map.edges) {
    if (const auto kept = Kept(edge, removed, by_id)) edges.push_back(*kept);
  }
  report.edges = static_cast<int>(map.edges.size() - edges.size());
  map.edges = std::move(edges);
  OutlinePlanes(map);
}

// The sequences of which a map has any content.
std::set<SequenceId> UsedSequences(const MapData& map) {
  std::set<SequenceId> used;
  for (const Keyframe& row : map.keyframes) used.insert(row.sequence);
  if (map.appearance) {
    for (const AppearanceNode& row : map.appearance->nodes) used.insert(row.sequence);
  }
  if (map.orientation) {
    for (const OrientationFrame& row : map.orientation->frames) used.insert(row.sequence);
  }
  return used;
}

// Sequences that were used and aren't any more, and sessions that have no sequence left.
int RemoveSequences(const std::set<SequenceId>& used_before, MapData& map) {
  std::set<SequenceId> empty = used_before;
  for (const SequenceId used : UsedSequences(map)) empty.erase(used);
  if (empty.empty()) return 0;
  std::vector<MapSession> sessions = SessionsOf(map);
  const bool has_history = HasHistory(map);
  std::erase_if(map.sequences, [&](const Sequence& row) { return empty.contains(row.id); });
  if (has_history) {
    for (MapSession& session : sessions) {
      std::erase_if(session.sequences, [&](SequenceId id) { return empty.contains(id); });
    }
    std::erase_if(sessions, [](const MapSession& row) { return row.sequences.empty(); });
    map.info.options_json = WithSessions(map.info.options_json, sessions);
  }
  return static_cast<int>(empty.size());
}

}  // namespace

RemoveResult RemoveFromMap(MapData map, const Removal& removed, const BuildOptions& options) {
  options.Check();
  CheckRemoval(map, removed);
  RemoveResult result;
  const std::set<SequenceId> used_before = UsedSequences(map);
  const std::set<OrientationFrameId> frames = FramesThatGo(map, removed);
  result.report.keyframes = static_cast<int>(removed.keyframes.size());
  result.report.panoramas = static_cast<int>(removed.nodes.size());
  result.report.orientation_frames = static_cast<int>(frames.size());
  const NamedBefore named(map);
  const LooksBefore looks(map);
  const PosesBefore poses(map);
  const bool had_poses = map.poses.has_value();
  RemoveNodes(removed.nodes, map);
  RemoveFrames(frames, map);
  if (!removed.keyframes.empty()) {
    RemoveFrom(map.keyframes, removed.keyframes);
    std::erase_if(map.links, [&](const KeyframeLink& link) {
      return removed.keyframes.contains(link.a) || removed.keyframes.contains(link.b);
    });
    RemoveFromPlanes(removed.keyframes, options.planes.min_features, map, result.report);
  }
  poses.KeepPoses(map);
  PutNodesIntoFrame(map);
  result.report.names = named.KeepNames(map);
  if (had_poses && !map.poses) {
    for (const FloorPlanImage& plan : map.floor_plans)
      result.report.floor_plans.push_back(plan.name);
    map.floor_plans.clear();
  }
  result.report.sequences = RemoveSequences(used_before, map);
  looks.KeepLooks(map);
  CompleteJoined(options, {!removed.keyframes.empty(), !removed.nodes.empty()}, map);
  result.map = std::move(map);
  return result;
}

}  // namespace waystone
