// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/named_places.h"

#include <algorithm>
#include <array>
#include <utility>

namespace waystone {
namespace {

// Cumulative counts up to each id of a kind, for counting what is in a range.
class Counts {
 public:
  explicit Counts(std::vector<int64_t> ids) : ids_(std::move(ids)) {
    for (size_t i = 0; i <= ids_.size(); ++i) before_.push_back(static_cast<double>(i));
  }
  // Each id counts with its weight.
  Counts(std::vector<int64_t> ids, const std::vector<double>& weights) : ids_(std::move(ids)) {
    before_.push_back(0);
    for (const double weight : weights) before_.push_back(before_.back() + weight);
  }

  double In(const NamedRange& range) const {
    const auto first = std::ranges::lower_bound(ids_, range.first) - ids_.begin();
    const auto last = std::ranges::upper_bound(ids_, range.last) - ids_.begin();
    return before_[last] - before_[first];
  }

 private:
  std::vector<int64_t> ids_;
  std::vector<double> before_;
};

Counts CountPlanes(const MapData& map) {
  std::vector<double> views;
  for (const Plane& plane : map.planes) views.push_back(static_cast<double>(plane.views.size()));
  return {IdsOf(map, NamedKind::kPlanes), views};
}

// Of a polygon. On large maps every n-th point is counted n times.
double CountHeld(const NamedPolygon& polygon, const std::vector<Eigen::Vector2d>& points) {
  constexpr size_t kMostCounted = 10'000;
  const size_t step = points.size() / kMostCounted + 1;
  double count = 0;
  for (size_t i = 0; i < points.size(); i += step) {
    if (Holds(polygon, points[i])) count += static_cast<double>(step);
  }
  return count;
}

}  // namespace

NamedPlaces::NamedPlaces(const MapData& map) {
  if (map.names.empty()) return;
  std::vector<Eigen::Vector2d> points;
  if (map.poses) {
    view_ = HorizontalOf(*map.poses);
    for (const KeyframePose& pose : map.poses->keyframes) {
      points.push_back(view_->Of(pose.position));
      positions_.emplace(pose.keyframe, points.back());
    }
    for (const NodePose& pose : map.poses->nodes) points.push_back(view_->Of(pose.position));
    nodes_are_in_view_ = !map.poses->nodes.empty();
  } else if (map.appearance) {
    for (const AppearanceNode& node : map.appearance->nodes) {
      points.emplace_back(node.pose.x, node.pose.y);
    }
  }
  const std::array counts{Counts(IdsOf(map, NamedKind::kKeyframes)),
                          Counts(IdsOf(map, NamedKind::kNodes)), CountPlanes(map)};
  std::vector<std::pair<double, const NamedPlace*>> order;
  for (const NamedPlace& place : map.names) {
    double width = 0;
    for (const NamedRange& range : place.ranges) {
      width += counts[static_cast<size_t>(range.kind)].In(range);
    }
    for (const NamedPolygon& polygon : place.polygons) width += CountHeld(polygon, points);
    order.emplace_back(width, &place);
  }
  std::ranges::stable_sort(order, {}, &std::pair<double, const NamedPlace*>::first);
  for (const auto& [width, place] : order) places_.push_back(*place);
}

const std::string* NamedPlaces::Find(const PlaceEvidence& evidence) const {
  const auto id_of = [&evidence](NamedKind kind) -> int64_t {
    switch (kind) {
      case NamedKind::kKeyframes:
        return evidence.keyframe ? evidence.keyframe->value : 0;
      case NamedKind::kNodes:
        return evidence.node ? evidence.node->value : 0;
      case NamedKind::kPlanes:
        return evidence.plane ? evidence.plane->value : 0;
    }
    return 0;
  };
  for (const NamedPlace& place : places_) {
    const bool in_range = std::ranges::any_of(place.ranges, [&](const NamedRange& range) {
      const int64_t id = id_of(range.kind);
      return range.first <= id && id <= range.last;
    });
    const bool in_area =
        evidence.position && std::ranges::any_of(place.polygons, [&](const NamedPolygon& polygon) {
          return Holds(polygon, *evidence.position);
        });
    if (in_range || in_area) return &place.name;
  }
  return nullptr;
}

const std::string* NamedPlaces::OfKeyframe(KeyframeId id) const {
  if (places_.empty()) return nullptr;
  return Find({.keyframe = id, .node = {}, .plane = {}, .position = PositionOf(id)});
}

const std::string* NamedPlaces::OfNode(const AppearanceNode& node) const {
  if (places_.empty()) return nullptr;
  return Find({.keyframe = {}, .node = node.id, .plane = {}, .position = PositionOf(node.pose)});
}

std::optional<Eigen::Vector2d> NamedPlaces::PositionOf(KeyframeId id) const {
  const auto found = positions_.find(id);
  if (found == positions_.end()) return std::nullopt;
  return found->second;
}

std::optional<Eigen::Vector2d> NamedPlaces::PositionOf(const Eigen::Vector3d& in_pose_layer) const {
  if (!view_) return std::nullopt;
  return view_->Of(in_pose_layer);
}

std::optional<Eigen::Vector2d> NamedPlaces::PositionOf(const Pose2& in_appearance_layer) const {
  if (view_ && !nodes_are_in_view_) return std::nullopt;
  return Eigen::Vector2d(in_appearance_layer.x, in_appearance_layer.y);
}

}  // namespace waystone
